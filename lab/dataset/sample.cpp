#include <earpoint/dataset/sample.h>

#include <algorithm>
#include <cstdlib>

#include <earpoint/audio/butterworth.h>

namespace earpoint {

Waveform highpass(const Waveform& sound, double cutoff_hz) {
  const int rate = sound.sample_rate_hz();
  const int below_nyquist_hz = rate / 2 - 1;
  const auto sections = butterworth_bandpass(cutoff_hz, static_cast<double>(below_nyquist_hz),
                                             static_cast<double>(rate));
  Waveform filtered(sound.channels(), sound.samples(), rate);
  std::vector<double> output(static_cast<std::size_t>(sound.samples()));
  for (int c = 0; c < sound.channels(); ++c) {
    const std::vector<double> input(sound.channel(c).begin(), sound.channel(c).end());
    filter_zero_phase(sections, input, output);
    std::transform(output.begin(), output.end(), filtered.channel(c).begin(),
                   [](double sample) { return static_cast<float>(sample); });
  }
  return filtered;
}

std::vector<float> mean_of_channels(const Waveform& sound) {
  std::vector<float> mean(static_cast<std::size_t>(sound.samples()));
  for (std::size_t i = 0; i < mean.size(); ++i) {
    mean[i] = (sound.channel(0)[i] + sound.channel(1)[i]) / 2.0F;
  }
  return mean;
}

Waveform shifted(const Waveform& sound, int delay_samples) {
  Waveform result(sound.channels(), sound.samples(), sound.sample_rate_hz());
  const std::ptrdiff_t from = std::max(0, -delay_samples);
  const std::ptrdiff_t to = std::max(0, delay_samples);
  const std::ptrdiff_t count =
      std::max<std::ptrdiff_t>(0, sound.samples() - std::abs(delay_samples));
  for (int c = 0; c < sound.channels(); ++c) {
    std::copy_n(sound.channel(c).begin() + std::min(from, sound.samples() - count), count,
                result.channel(c).begin() + std::min(to, sound.samples() - count));
  }
  return result;
}

}  // namespace earpoint

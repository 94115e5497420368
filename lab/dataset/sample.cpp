#include <earpoint/dataset/sample.h>

#include <algorithm>

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

Waveform window_of(const Waveform& sound, std::ptrdiff_t start, std::ptrdiff_t samples) {
  Waveform window(sound.channels(), samples, sound.sample_rate_hz());
  const std::ptrdiff_t count = std::clamp(sound.samples() - start, std::ptrdiff_t{0}, samples);
  for (int c = 0; c < sound.channels(); ++c) {
    std::copy_n(sound.channel(c).begin() + start, count, window.channel(c).begin());
  }
  return window;
}

}  // namespace earpoint

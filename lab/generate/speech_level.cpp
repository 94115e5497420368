#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/error.h>
#include <earpoint/generate/speech_corpus.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;
constexpr std::ptrdiff_t kFrame = 320;    // 20 ms
constexpr std::ptrdiff_t kMargin = 1600;  // silence that is kept at both ends
constexpr double kShortest_s = 0.5;
// Frames this far below the loudest are silent.
constexpr double kSilence_db = -40.0;
constexpr double kActivityMargin_db = 15.9;
constexpr double kLevel_db = -26.0;
constexpr double kHighestPeak = 0.89;  // -1 dB

Waveform mixed(const Waveform& sound) {
  Waveform mono(1, sound.samples(), sound.sample_rate_hz());
  for (int c = 0; c < sound.channels(); ++c) {
    for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
      mono.channel(0)[i] += sound.channel(c)[i] / static_cast<float>(sound.channels());
    }
  }
  return mono;
}

/// The mean square of each 20 ms.
std::vector<double> frame_powers(std::span<const float> samples) {
  std::vector<double> powers;
  for (std::ptrdiff_t begin = 0; begin + kFrame <= std::ssize(samples); begin += kFrame) {
    double sum = 0.0;
    for (std::ptrdiff_t i = begin; i < begin + kFrame; ++i) {
      sum += static_cast<double>(samples[i]) * samples[i];
    }
    powers.push_back(sum / kFrame);
  }
  return powers;
}

/// The mean power of the frames with speech: those above a threshold 15.9 dB below that mean.
double active_power(const std::vector<double>& powers) {
  double mean = 0.0;
  for (const double power : powers) mean += power / static_cast<double>(powers.size());
  for (int round = 0; round < 20; ++round) {
    const double threshold = mean * std::pow(10.0, -kActivityMargin_db / 10.0);
    double sum = 0.0;
    std::size_t count = 0;
    for (const double power : powers) {
      if (power < threshold) continue;
      sum += power;
      ++count;
    }
    const double next = sum / static_cast<double>(count);
    if (std::abs(next - mean) <= 1e-9 * mean) break;
    mean = next;
  }
  return mean;
}

}  // namespace

Waveform prepare_speech(const Waveform& sound, std::string_view where) {
  const Waveform speech = resample(mixed(sound), kRate_hz);
  const auto samples = speech.channel(0);
  const std::vector<double> powers = frame_powers(samples);
  const auto loudest = std::max_element(powers.begin(), powers.end());
  if (loudest == powers.end() || *loudest <= 0.0) throw InputError(where, "is silent");
  const double floor = *loudest * std::pow(10.0, kSilence_db / 10.0);
  const auto is_loud = [&](double power) { return power >= floor; };
  const auto first = std::find_if(powers.begin(), powers.end(), is_loud) - powers.begin();
  const auto last = std::find_if(powers.rbegin(), powers.rend(), is_loud).base() - powers.begin();
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, first * kFrame - kMargin);
  const std::ptrdiff_t end = std::min(speech.samples(), last * kFrame + kMargin);
  Waveform trimmed(1, end - begin, kRate_hz);
  if (trimmed.duration_s() < kShortest_s) {
    throw InputError(where, fmt::format("holds {:.2f} s of speech, expected {:g} s or more",
                                        trimmed.duration_s(), kShortest_s));
  }
  const auto spoken = trimmed.channel(0);
  std::copy(samples.begin() + begin, samples.begin() + end, spoken.begin());
  float peak = 0.0F;
  for (const float sample : spoken) peak = std::max(peak, std::abs(sample));
  const double wanted = std::pow(10.0, kLevel_db / 20.0) / std::sqrt(active_power(powers));
  const auto gain = static_cast<float>(std::min(wanted, kHighestPeak / peak));
  for (float& sample : spoken) sample *= gain;
  return trimmed;
}

Waveform read_speech(const std::filesystem::path& path) {
  return prepare_speech(read_sound(path), path.string());
}

}  // namespace earpoint

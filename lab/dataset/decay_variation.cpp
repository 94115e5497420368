#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <earpoint/audio/butterworth.h>
#include <earpoint/audio/decay.h>
#include <earpoint/audio/energy.h>
#include <earpoint/dataset/reverberant_speech.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kRateHz = 16000.0;
// The octaves around 500 and 1000 Hz.
constexpr double kLowHz = 353.6;
constexpr double kHighHz = 1414.2;
constexpr int kBandOrder = 3;
const double kSixtyDb = 3.0 * std::numbers::ln10;  ///< of an amplitude, in nepers

const std::vector<SecondOrderSection>& middle_octaves() {
  static const std::vector<SecondOrderSection> sections =
      butterworth_bandpass(kLowHz, kHighHz, kRateHz, kBandOrder);
  return sections;
}

std::size_t largest(std::span<const float> response) {
  const auto at = std::ranges::max_element(
      response, [](float a, float b) { return std::abs(a) < std::abs(b); });
  return static_cast<std::size_t>(at - response.begin());
}

/// A one-pole low-pass, in place: coarse octave bands are good enough for noise.
void smooth(std::vector<float>& samples, double cutoff_hz) {
  const auto keep = static_cast<float>(std::exp(-2.0 * std::numbers::pi * cutoff_hz / kRateHz));
  float state = 0.0F;
  for (float& x : samples) x = state = keep * state + (1.0F - keep) * x;
}

/// White noise that fades in as reflections grow denser, and out by 60 dB in `t60_s`.
std::vector<float> fading_noise(double t60_s, double dense_from_s, std::ptrdiff_t samples,
                                RandomStream& random) {
  std::vector<float> noise(static_cast<std::size_t>(samples));
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const double t = static_cast<double>(i) / kRateHz;
    const double density = std::min(1.0, 0.02 + t / dense_from_s);
    const double value = random.uniform() < density ? random.normal() / std::sqrt(density) : 0.0;
    noise[i] = static_cast<float>(value * std::exp(-kSixtyDb * t / t60_s));
  }
  return noise;
}

}  // namespace

std::optional<double> middle_t60_s(std::span<const float> response) {
  const auto& sections = middle_octaves();
  if (std::ssize(response) <= zero_phase_extension(sections)) return std::nullopt;
  std::vector<double> samples(response.begin(), response.end());
  filter_zero_phase(sections, samples, samples);
  const std::vector<float> band(samples.begin(), samples.end());
  try {
    return reverberation_time_t30_s(band, kRateHz);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

std::vector<float> noise_response(double t60_s, std::ptrdiff_t samples, RandomStream& random) {
  EARPOINT_CHECK(t60_s > 0.0 && samples > 0);
  const double dense_from_s = random.uniform(0.01, 0.08);
  // Low frequencies mostly decay more slowly than high ones.
  const double slope = random.uniform(0.75, 1.1);
  constexpr std::array<double, 3> kCutoffsHz{500.0, 2000.0, 8000.0};
  std::vector<float> response(static_cast<std::size_t>(samples));
  for (std::size_t band = 0; band < kCutoffsHz.size(); ++band) {
    const double pace = std::pow(slope, static_cast<double>(band) - 1.0);
    std::vector<float> noise = fading_noise(t60_s * pace, dense_from_s, samples, random);
    std::vector<float> below = noise;
    if (band + 1 < kCutoffsHz.size()) smooth(noise, kCutoffsHz[band]);
    if (band > 0) smooth(below, kCutoffsHz[band - 1]);
    for (std::size_t i = 0; i < response.size(); ++i) {
      response[i] += noise[i] - (band > 0 ? below[i] : 0.0F);
    }
  }
  const double direct_db = random.uniform(-10.0, 8.0);
  response[0] = static_cast<float>(std::sqrt(energy(response) * std::pow(10.0, direct_db / 10.0)));
  return response;
}

void change_decay(std::span<float> response, double from_s, double to_s) {
  EARPOINT_CHECK(from_s > 0.0 && to_s > 0.0);
  const double pace = kSixtyDb * (1.0 / to_s - 1.0 / from_s);
  const std::size_t direct = largest(response);
  for (std::size_t i = direct; i < response.size(); ++i) {
    const double t = static_cast<double>(i - direct) / kRateHz;
    response[i] = static_cast<float>(response[i] * std::exp(-pace * t));
  }
}

}  // namespace earpoint

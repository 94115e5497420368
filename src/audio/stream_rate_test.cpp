#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/stream_rate.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

std::vector<float> tone(double frequency_hz, int rate_hz, std::ptrdiff_t samples) {
  std::vector<float> sound(static_cast<std::size_t>(samples));
  for (std::ptrdiff_t i = 0; i < samples; ++i) {
    sound[i] =
        static_cast<float>(std::sin(2.0 * kPi * frequency_hz * static_cast<double>(i) / rate_hz));
  }
  return sound;
}

std::vector<float> converted(const std::vector<float>& sound, int from_hz, int to_hz,
                             std::ptrdiff_t block) {
  StreamRate rate(1, from_hz, to_hz);
  std::vector<float> result;
  for (std::size_t start = 0; start + block <= sound.size(); start += block) {
    std::vector<float> part(static_cast<std::size_t>(block * to_hz / from_hz));
    rate.process(std::span(sound).subspan(start, block), part);
    result.insert(result.end(), part.begin(), part.end());
  }
  return result;
}

class StreamRates : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(StreamRates, KeepTonesBelowTheLowerNyquistFrequencyAndDelayThemByFiveMilliseconds) {
  const auto [from_hz, to_hz] = GetParam();
  const double nyquist_hz = std::min(from_hz, to_hz) / 2.0;
  const std::ptrdiff_t block = from_hz / 50;
  for (const double frequency_hz : {100.0, 1000.0, nyquist_hz / 2.0, nyquist_hz - 500.0}) {
    const std::vector<float> found =
        converted(tone(frequency_hz, from_hz, from_hz / 2), from_hz, to_hz, block);
    double worst = 0.0;
    for (std::size_t i = static_cast<std::size_t>(to_hz / 20); i < found.size(); ++i) {
      const double time_s = static_cast<double>(i) / to_hz - 0.005;
      worst = std::max(worst, std::abs(found[i] - std::sin(2.0 * kPi * frequency_hz * time_s)));
    }
    // A ripple of -90 dB in the pass band, and float rounding over some hundred taps.
    EXPECT_LT(worst, 5e-5) << frequency_hz << " Hz";
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, StreamRates,
                         testing::Values(std::tuple(48000, 16000), std::tuple(16000, 48000),
                                         std::tuple(44100, 16000), std::tuple(16000, 44100),
                                         std::tuple(22050, 16000), std::tuple(96000, 16000)));

TEST(StreamRate, LeavesNothingOfWhatTheLowerRateCannotCarry) {
  for (const double frequency_hz : {8600.0, 10000.0, 15000.0, 23000.0}) {
    const std::vector<float> found = converted(tone(frequency_hz, 48000, 24000), 48000, 16000, 480);
    const float peak =
        std::abs(*std::max_element(found.begin() + 800, found.end(),
                                   [](float a, float b) { return std::abs(a) < std::abs(b); }));
    EXPECT_LT(20.0 * std::log10(peak), -90.0) << frequency_hz << " Hz";
  }
}

TEST(StreamRate, GivesTheSameForBlocksOfAnySize) {
  const std::vector<float> sound = tone(440.0, 44100, 44100);
  const std::vector<float> once = converted(sound, 44100, 16000, 44100);
  EXPECT_EQ(converted(sound, 44100, 16000, 441), once);
}

TEST(StreamRate, PassesEqualRatesOn) {
  const std::vector<float> sound = tone(440.0, 16000, 1600);
  EXPECT_EQ(converted(sound, 16000, 16000, 160), sound);
  EXPECT_EQ(StreamRate(1, 16000, 16000).delay_s(), 0.0);
}

}  // namespace
}  // namespace earpoint

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <earpoint/audio/loudness.h>

namespace earpoint {
namespace {

Waveform sine(int channels, int rate_hz, double amplitude, double from_s, double to_s,
              double duration_s) {
  Waveform sound(channels, std::lround(duration_s * rate_hz), rate_hz);
  for (std::ptrdiff_t i = std::lround(from_s * rate_hz); i < std::lround(to_s * rate_hz); ++i) {
    const double phase = 2.0 * std::numbers::pi * 997.0 * static_cast<double>(i) / rate_hz;
    for (int c = 0; c < channels; ++c) {
      sound.channel(c)[i] = static_cast<float>(amplitude * std::sin(phase));
    }
  }
  return sound;
}

// The recommendation states this value to a hundredth. The onset of the filters adds less than 0.01
// dB: a few periods out of 5 s.
constexpr double kTolerance_lu = 0.02;

TEST(Loudness, SineAtFullScaleIsWhatTheRecommendationSays) {
  EXPECT_NEAR(loudness_lkfs(sine(1, 48000, 1.0, 0, 5, 5)).value(), -3.01, kTolerance_lu);
  // Twice the power, half the amplitude.
  EXPECT_NEAR(loudness_lkfs(sine(2, 48000, 1.0, 0, 5, 5)).value(), 0.0, kTolerance_lu);
  EXPECT_NEAR(loudness_lkfs(sine(1, 48000, 0.1, 0, 5, 5)).value(), -23.01, kTolerance_lu);
}

TEST(Loudness, IsTheSameAtEveryRate) {
  for (const int rate_hz : {16000, 44100}) {
    EXPECT_NEAR(loudness_lkfs(sine(1, rate_hz, 1.0, 0, 5, 5)).value(), -3.01, kTolerance_lu)
        << rate_hz;
  }
}

TEST(Loudness, SilenceAroundTheSoundDoesNotCount) {
  // 8 s of sine in 20 s of silence. Blocks at both ends have part of the sine and pass the gate:
  // three of 80 at either end, with 25, 50 and 75 % of the power, reduce it by 0.16 dB.
  const double loudness = loudness_lkfs(sine(1, 48000, 0.5, 6, 14, 20)).value();
  EXPECT_NEAR(loudness, -9.03 - 0.16, 0.03);
}

TEST(Loudness, ShortSoundIsOneBlockAndSilenceHasNone) {
  // A sine of full scale has -3.01 LKFS. The high-pass of the weighting rings when the sine begins,
  // which counts for more in 0.2 s.
  EXPECT_NEAR(loudness_lkfs(sine(1, 48000, 1.0, 0, 0.2, 0.2)).value(), -3.01, 0.1);
  EXPECT_FALSE(loudness_lkfs(Waveform(2, 48000, 48000)).has_value());
  EXPECT_FALSE(loudness_lkfs(sine(1, 48000, 1e-5, 0, 1, 1)).has_value());  // -103 LKFS
}

}  // namespace
}  // namespace earpoint

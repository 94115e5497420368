#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/peak_limiter.h>
#include <earpoint/core/random.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;

Waveform noise(std::ptrdiff_t samples, double size, std::uint64_t seed) {
  Waveform sound(2, samples, kRate_hz);
  RandomStream random(seed);
  for (float& sample : sound.planar()) sample = static_cast<float>(size * random.normal());
  return sound;
}

/// The stream in blocks of changing length.
Waveform limited(const Waveform& sound, PeakLimiter& limiter) {
  Waveform result(2, sound.samples(), kRate_hz);
  std::ptrdiff_t written = 0;
  std::ptrdiff_t length = 1;
  for (std::ptrdiff_t start = 0; start < sound.samples(); start += length) {
    length = std::min<std::ptrdiff_t>(1 + start % 700, sound.samples() - start);
    Waveform block(2, length, kRate_hz);
    for (int c = 0; c < 2; ++c) {
      std::copy_n(sound.channel(c).begin() + start, length, block.channel(c).begin());
    }
    const Waveform part = limiter.process(block, start + length == sound.samples());
    for (int c = 0; c < 2; ++c) {
      std::ranges::copy(part.channel(c), result.channel(c).begin() + written);
    }
    written += part.samples();
  }
  EXPECT_EQ(written, sound.samples());
  return result;
}

TEST(PeakLimiter, PassesWhatStaysWithinFullScaleUnchanged) {
  Waveform sound = noise(9000, 0.2, 1);
  for (float& sample : sound.planar()) sample = std::clamp(sample, -1.0F, 1.0F);
  PeakLimiter limiter(2, kRate_hz);
  const Waveform found = limited(sound, limiter);
  EXPECT_TRUE(std::ranges::equal(found.planar(), sound.planar()));
  EXPECT_EQ(limiter.excess_db(), 0.0);
}

TEST(PeakLimiter, LetsNothingBeyondFullScale) {
  const Waveform sound = noise(20000, 3.0, 2);
  PeakLimiter limiter(2, kRate_hz);
  float peak = 0.0F;
  const Waveform found = limited(sound, limiter);
  for (const float sample : found.planar()) peak = std::max(peak, std::abs(sample));
  EXPECT_LE(peak, 1.0F);
  // Sound that is always too loud stays near full scale, not far below.
  EXPECT_GT(peak, 0.9F);
  float loudest = 0.0F;
  for (const float sample : sound.planar()) loudest = std::max(loudest, std::abs(sample));
  EXPECT_NEAR(limiter.excess_db(), 20.0 * std::log10(loudest), 1e-5);
}

TEST(PeakLimiter, KeepsTheLevelBetweenTheEarsAndTheWaveform) {
  // A tone of 12 dB over full scale at the left, a hundredth of it at the right.
  Waveform sound(2, 16000, kRate_hz);
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    sound.channel(0)[i] =
        static_cast<float>(4.0 * std::sin(2 * kPi * 440 / kRate_hz * static_cast<double>(i)));
    sound.channel(1)[i] = 0.01F * sound.channel(0)[i];
  }
  PeakLimiter limiter(2, kRate_hz);
  const Waveform found = limited(sound, limiter);
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    ASSERT_NEAR(found.channel(1)[i], 0.01F * found.channel(0)[i], 1e-7) << i;
  }
  // The settled gain ripples by the release within half a period of 1.1 ms: 2 %.
  for (std::ptrdiff_t i = 4000; i < 12000; ++i) {
    ASSERT_NEAR(found.channel(0)[i], sound.channel(0)[i] / 4, 0.03) << i;
  }
}

TEST(PeakLimiter, ReturnsToUnchangedSoundAfterAPeak) {
  Waveform sound = noise(24000, 0.1, 3);
  sound.channel(0)[5000] = 8.0F;
  PeakLimiter limiter(2, kRate_hz);
  const Waveform found = limited(sound, limiter);
  for (std::ptrdiff_t i = 0; i < 24000; ++i) {
    // 5 ms before the peak and 0.57 s after it: the release from 7/8 to 1e-5 at 50 ms.
    if (i > 5000 - 82 && i < 5000 + 9300) continue;
    ASSERT_EQ(found.channel(0)[i], sound.channel(0)[i]) << i;
  }
  EXPECT_FLOAT_EQ(found.channel(0)[5000], 1.0F);
}

}  // namespace
}  // namespace earpoint

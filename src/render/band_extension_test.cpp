#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>
#include <earpoint/render/band_extension.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kWindow = 1600;
constexpr std::ptrdiff_t kOverlap = 400;

Waveform noise(RandomStream& random) {
  Waveform window(2, kWindow, 16000);
  for (float& sample : window.planar()) sample = static_cast<float>(random.normal());
  return window;
}

Waveform scaled(const Waveform& window, float left, float right) {
  Waveform result = window;
  for (float& sample : result.channel(0)) sample *= left;
  for (float& sample : result.channel(1)) sample *= right;
  return result;
}

TEST(BandExtension, FollowsEachEarsTopOctaveAndFadesBetweenWindows) {
  RandomStream random(1);
  BandExtension extension(kWindow, kOverlap);
  for (const float left : {0.5F, 2.0F}) {
    const Waveform input = noise(random);
    extension.add_window(input, scaled(input, left, 0.25F));
  }
  constexpr double kHop = kWindow - kOverlap;
  // The same samples with a gain: only float rounding of the transform differs.
  EXPECT_NEAR(extension.gain(0, 10), 0.5F, 1e-5);
  EXPECT_NEAR(extension.gain(0, kHop), 0.5F, 1e-5);
  EXPECT_NEAR(extension.gain(0, kHop + kOverlap / 2.0), 1.25F, 1e-5);
  EXPECT_NEAR(extension.gain(0, kHop + kOverlap), 2.0F, 1e-5);
  EXPECT_NEAR(extension.gain(0, 3 * kHop), 2.0F, 1e-5);
  EXPECT_NEAR(extension.gain(1, kHop + 3), 0.25F, 1e-5);
}

TEST(BandExtension, AddsEverySampleAtItsGain) {
  RandomStream random(4);
  BandExtension extension(kWindow, kOverlap);
  for (const float left : {0.5F, 2.0F, 0.1F}) {
    const Waveform input = noise(random);
    extension.add_window(input, scaled(input, left, 1.0F));
  }
  const std::vector<float> ones(9001, 1.0F);
  std::vector<float> sum(ones.size(), 3.0F);
  extension.add(0, 100.0, 16000.0 / 44100.0, ones, sum);
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const float expected = extension.gain(0, 100.0 + 16000.0 / 44100.0 * static_cast<double>(i));
    // Float sums of about 5; a sample at a window boundary may be rounded to either side.
    ASSERT_NEAR(sum[i], 3.0F + expected, 1e-6F) << i;
  }
}

TEST(BandExtension, IsDeafToTheLowBand) {
  RandomStream random(2);
  BandExtension extension(kWindow, kOverlap);
  const Waveform input = noise(random);
  Waveform output = input;
  for (std::ptrdiff_t i = 0; i < kWindow; ++i) {
    output.channel(0)[i] +=
        static_cast<float>(100.0 * std::sin(2 * kPi * 500.0 * static_cast<double>(i) / 16000.0));
  }
  extension.add_window(input, output);
  // The tone is 40 dB above the noise; the taper leaves a ten-thousandth of it in the top octave.
  EXPECT_NEAR(extension.gain(0, 0), 1.0, 1e-2);
}

TEST(BandExtension, NeverBoostsBeyondItsLimitAndPassesWhereNothingIsKnown) {
  RandomStream random(3);
  BandExtension extension(kWindow, kOverlap);
  const Waveform input = scaled(noise(random), 1.0F, 0.0F);
  extension.add_window(input, scaled(input, 50.0F, 1.0F));
  EXPECT_EQ(extension.gain(0, 0), 4.0F);
  EXPECT_EQ(extension.gain(1, 0), 1.0F);
}

}  // namespace
}  // namespace earpoint

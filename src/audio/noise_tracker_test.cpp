#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/noise_tracker.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

constexpr int kBins = 257;
constexpr double kHop_s = 0.008;
constexpr int kFramesPerSecond = 125;

/// Power of a frame of complex noise of that mean power: exponentially distributed.
std::vector<float> noise_frame(double mean, RandomStream& random) {
  std::vector<float> power(kBins);
  for (float& value : power) {
    value = static_cast<float>(-mean * std::log(1.0 - random.uniform()));
  }
  return power;
}

double mean_db(std::span<const float> values) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return 10.0 * std::log10(sum / static_cast<double>(values.size()));
}

/// A tracker that has heard two seconds of noise of power 1.
NoiseTracker settled(RandomStream& random) {
  NoiseTracker tracker(kBins, kHop_s);
  std::vector<float> start;
  for (int i = 0; i < kFramesPerSecond; ++i) {
    const std::vector<float> frame = noise_frame(1.0, random);
    start.insert(start.end(), frame.begin(), frame.end());
  }
  tracker.start(start);
  for (int i = 0; i < 2 * kFramesPerSecond; ++i) tracker.update(noise_frame(1.0, random));
  return tracker;
}

// Over 257 bins and an average over about 39 frames the standard error of the mean is below 0.1 dB.
// Frames with a smoothed power 7 dB above the minimum are left out, which makes the estimate up to
// 0.5 dB too low.
constexpr double kBias_db = 0.6;

TEST(NoiseTracker, FindsThePowerOfStationaryNoise) {
  RandomStream random(1);
  EXPECT_NEAR(mean_db(settled(random).noise()), 0.0, kBias_db);
}

TEST(NoiseTracker, KnowsTheNoiseAfterTheFirstSecond) {
  RandomStream random(2);
  NoiseTracker tracker(kBins, kHop_s);
  std::vector<float> start;
  // Speech 30 dB above the noise from the first frame on, with a pause of a third of a second.
  for (int i = 0; i < kFramesPerSecond; ++i) {
    const bool pause = i > 70 && i < 112;
    const std::vector<float> frame = noise_frame(pause ? 1.0 : 1000.0, random);
    start.insert(start.end(), frame.begin(), frame.end());
  }
  tracker.start(start);
  // The smoothed power falls to within 1 dB of the noise in 36 frames (0.8^36 of 1000 is 0.3).
  // Nothing is averaged in them yet: the estimate is 1.5 times the minimum of the other frames.
  EXPECT_NEAR(mean_db(tracker.noise()), 0.0, 2.0);
}

TEST(NoiseTracker, DoesNotTakeSyllablesForNoise) {
  RandomStream random(3);
  NoiseTracker tracker = settled(random);
  for (int i = 0; i < 4 * kFramesPerSecond; ++i) {
    tracker.update(noise_frame(i % 60 < 25 ? 1000.0 : 1.0, random));
  }
  // The first frame raises the smoothed power by a fifth of 30 dB, far above 7 dB. At the end of a
  // syllable the smoothed power takes 24 frames to fall within 7 dB; by then only noise is left.
  EXPECT_NEAR(mean_db(tracker.noise()), 0.0, kBias_db);
}

TEST(NoiseTracker, FollowsAFallWithinThreeTenthsOfASecond) {
  RandomStream random(4);
  NoiseTracker tracker = settled(random);
  // The average has a time constant of 20 frames of 8 ms. After a fall of 6 dB it takes ln 3 = 1.1
  // time constants, 0.18 s, to come within 3 dB.
  for (int i = 0; i < 0.3 * kFramesPerSecond; ++i) tracker.update(noise_frame(0.25, random));
  EXPECT_NEAR(mean_db(tracker.noise()), -6.0, 3.0);
}

TEST(NoiseTracker, FollowsARiseOfTenDecibelsWithinItsStatedTimeAndNotBefore) {
  RandomStream random(5);
  NoiseTracker tracker = settled(random);
  const int stated = static_cast<int>(1.6 * kFramesPerSecond);
  for (int i = 0; i < kFramesPerSecond / 4; ++i) tracker.update(noise_frame(10.0, random));
  EXPECT_LT(mean_db(tracker.noise()), 5.0);
  for (int i = kFramesPerSecond / 4; i < stated; ++i) tracker.update(noise_frame(10.0, random));
  // Three time constants after the last quiet window has passed, the average is off by 5 % of the
  // step in power, 0.2 dB; the rest is bias.
  EXPECT_NEAR(mean_db(tracker.noise()), 10.0, 1.0);
}

TEST(NoiseTracker, HoldsTheSameTimesForOtherHops) {
  RandomStream random(6);
  NoiseTracker tracker(kBins, 2.0 * kHop_s);
  tracker.start(noise_frame(1.0, random));
  for (int i = 0; i < kFramesPerSecond; ++i) tracker.update(noise_frame(1.0, random));
  for (int i = 0; i < 0.8 * kFramesPerSecond; ++i) tracker.update(noise_frame(10.0, random));
  // As above: 0.2 dB, and bias.
  EXPECT_NEAR(mean_db(tracker.noise()), 10.0, 1.0);
}

}  // namespace
}  // namespace earpoint

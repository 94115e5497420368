#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>
#include <earpoint/render/overlap_adder.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kWindow = 1000;
constexpr std::ptrdiff_t kOverlap = 250;
constexpr std::ptrdiff_t kHop = kWindow - kOverlap;

/// Joins `count` windows made by fill(window index, sample number in the stream).
template <typename Fill>
std::vector<float> join(int count, Fill fill) {
  OverlapAdder adder(kWindow, kOverlap);
  std::vector<float> joined;
  const auto append = [&](const Waveform& part) {
    joined.insert(joined.end(), part.channel(0).begin(), part.channel(0).end());
  };
  for (int k = 0; k < count; ++k) {
    Waveform window(1, kWindow, 16000);
    for (std::ptrdiff_t i = 0; i < kWindow; ++i) window.channel(0)[i] = fill(k, k * kHop + i);
    append(adder.add(window));
  }
  append(adder.flush());
  return joined;
}

TEST(OverlapAdder, EqualWindowsPassUnchanged) {
  const auto tone = [](std::ptrdiff_t n) {
    return static_cast<float>(std::sin(0.1 * static_cast<double>(n)));
  };
  const auto joined = join(4, [&](int, std::ptrdiff_t n) { return tone(n); });
  ASSERT_EQ(joined.size(), static_cast<std::size_t>(3 * kHop + kWindow));
  for (std::size_t n = 0; n < joined.size(); ++n) {
    // One rounding of the weighted sum.
    ASSERT_NEAR(joined[n], tone(static_cast<std::ptrdiff_t>(n)), 2e-7) << n;
  }
}

TEST(OverlapAdder, UnrelatedWindowsKeepTheirPowerThroughTheFade) {
  std::vector<double> power(kOverlap, 0.0);
  constexpr int kTrials = 2000;
  RandomStream random(1);
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto joined =
        join(2, [&](int, std::ptrdiff_t) { return static_cast<float>(random.normal()); });
    for (std::ptrdiff_t i = 0; i < kOverlap; ++i) {
      power[i] += static_cast<double>(joined[kHop + i]) * joined[kHop + i] / kTrials;
    }
  }
  // A mean of 2000 squared normals has a standard error of 3.2 %, the mean over the fade far less;
  // random correlation within a pair of windows adds about half a percent.
  double mean = 0.0;
  for (const double value : power) {
    EXPECT_NEAR(value, 1.0, 5 * 0.032);
    mean += value / kOverlap;
  }
  EXPECT_NEAR(mean, 1.0, 0.02);
}

TEST(OverlapAdder, OpposedWindowsFadeLikeUnrelatedOnes) {
  const auto tone = [](std::ptrdiff_t n) { return std::sin(0.1 * static_cast<double>(n)); };
  const auto joined = join(
      2, [&](int k, std::ptrdiff_t n) { return static_cast<float>(k == 0 ? tone(n) : -tone(n)); });
  ASSERT_EQ(joined.size(), static_cast<std::size_t>(kHop + kWindow));
  for (std::size_t n = 0; n < joined.size(); ++n) {
    // Progress of the fade to the second window: 0 before the overlap, 1 after it.
    const double way = std::clamp(
        (static_cast<double>(n) - static_cast<double>(kHop) + 0.5) / double{kOverlap}, 0.0, 1.0);
    const double rising = std::pow(std::sin(kPi / 2 * way), 2.0);
    const double falling = 1.0 - rising;
    const double expected =
        tone(static_cast<std::ptrdiff_t>(n)) * (falling - rising) / std::hypot(falling, rising);
    // Each window is rounded to float, and their sum again: three times 6e-8, of samples up to 1.
    ASSERT_NEAR(joined[n], expected, 2e-7) << n;
  }
}

}  // namespace
}  // namespace earpoint

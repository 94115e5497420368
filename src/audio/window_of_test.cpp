#include <algorithm>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/window_of.h>

namespace earpoint {
namespace {

TEST(WindowOf, TakesAPartAndFollowsTheEndWithZeros) {
  Waveform sound(2, 4, 16000);
  std::ranges::copy(std::vector<float>{1, 2, 3, 4, -1, -2, -3, -4}, sound.planar().begin());
  const auto values = [&](std::ptrdiff_t start, std::ptrdiff_t samples) {
    const Waveform part = window_of(sound, start, samples);
    EXPECT_EQ(part.channels(), 2);
    EXPECT_EQ(part.samples(), samples);
    EXPECT_EQ(part.sample_rate_hz(), 16000);
    return std::vector<float>(part.planar().begin(), part.planar().end());
  };
  EXPECT_EQ(values(1, 2), (std::vector<float>{2, 3, -2, -3}));
  EXPECT_EQ(values(0, 4), (std::vector<float>{1, 2, 3, 4, -1, -2, -3, -4}));
  EXPECT_EQ(values(3, 3), (std::vector<float>{4, 0, 0, -4, 0, 0}));
  EXPECT_EQ(values(9, 1), (std::vector<float>{0, 0}));
  EXPECT_EQ(values(4, 0), std::vector<float>());
  EXPECT_THROW(static_cast<void>(window_of(sound, -1, 2)), std::logic_error);
}

}  // namespace
}  // namespace earpoint

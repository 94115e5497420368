#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/convolution.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

std::vector<float> noise(std::ptrdiff_t samples, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> signal(samples);
  for (float& x : signal) x = static_cast<float>(random.uniform(-1.0, 1.0));
  return signal;
}

std::vector<double> direct_sum(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<double> result(a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) result[i + j] += double{a[i]} * b[j];
  }
  return result;
}

/// Float transforms of blocks whose results are about sqrt(taps) large.
double tolerance(std::size_t taps) { return 2e-6 * std::sqrt(static_cast<double>(taps)) + 1e-6; }

TEST(Convolve, EqualsTheDirectSum) {
  for (const auto& [length, taps] : {std::pair{1, 1},
                                     {5, 3},
                                     {1000, 32},
                                     {1000, 33},
                                     {100, 100},
                                     {33, 1000},
                                     {4000, 257},
                                     {10007, 1999}}) {
    const std::vector<float> a = noise(length, 1);
    const std::vector<float> b = noise(taps, 2);
    const std::vector<double> expected = direct_sum(a, b);
    const std::vector<float> found = convolve(a, b);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t n = 0; n < found.size(); ++n) {
      ASSERT_NEAR(found[n], expected[n], tolerance(std::min(a.size(), b.size())))
          << length << " x " << taps << " at " << n;
    }
  }
}

TEST(Convolve, WithNothingIsNothing) {
  EXPECT_TRUE(convolve({}, noise(3, 1)).empty());
  EXPECT_TRUE(convolve(noise(3, 1), {}).empty());
}

TEST(PartitionedConvolver, StreamEqualsTheDirectSum) {
  for (const int taps : {1, 64, 65, 1000}) {
    for (const int block : {1, 50, 64, 160}) {
      const std::vector<float> signal = noise(std::ptrdiff_t{12} * block, 3);
      const std::vector<float> response = noise(taps, 4);
      const std::vector<double> expected = direct_sum(signal, response);
      PartitionedConvolver convolver(response, block);
      EXPECT_EQ(convolver.block_size(), block);
      std::vector<float> samples = signal;
      for (std::size_t start = 0; start < samples.size(); start += block) {
        const std::span<float> part = std::span(samples).subspan(start, block);
        convolver.process(part, part);  // in place
      }
      for (std::size_t n = 0; n < samples.size(); ++n) {
        ASSERT_NEAR(samples[n], expected[n], tolerance(response.size()))
            << taps << " taps, block " << block << ", sample " << n;
      }
    }
  }
}

TEST(PartitionedConvolver, ResetForgetsTheTail) {
  const std::vector<float> response = noise(500, 5);
  const auto tail = [&](bool reset) {
    PartitionedConvolver convolver(response, 100);
    std::vector<float> loud(100, 1.0F);
    convolver.process(loud, loud);
    if (reset) convolver.reset();
    std::vector<float> silence(100, 0.0F);
    convolver.process(silence, silence);
    return silence;
  };
  EXPECT_EQ(tail(true), std::vector<float>(100, 0.0F));
  EXPECT_NE(tail(false), std::vector<float>(100, 0.0F));
}

TEST(PartitionedConvolver, WrongBlocksAreTheCallersBug) {
  const std::vector<float> response = noise(5, 6);
  EXPECT_THROW(PartitionedConvolver({}, 8), std::logic_error);
  EXPECT_THROW(PartitionedConvolver(response, 0), std::logic_error);
  PartitionedConvolver convolver(response, 8);
  std::vector<float> block(7);
  EXPECT_THROW(convolver.process(block, block), std::logic_error);
}

}  // namespace
}  // namespace earpoint

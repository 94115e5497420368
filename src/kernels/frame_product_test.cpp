#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/kernels/frame_product.h>
#include <earpoint/kernels_testing/every_target.h>

namespace earpoint::kernels {
namespace {

std::vector<float> noise(std::size_t count, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(random.uniform(-1.0, 1.0));
  return values;
}

TEST(FrameMatrix, MultipliesEveryFrameOnEveryProcessor) {
  constexpr std::ptrdiff_t kInputs = 13;
  constexpr std::ptrdiff_t kOutputs = 21;
  constexpr std::ptrdiff_t kFrames = 7;
  constexpr std::ptrdiff_t kStride = 15;
  const std::vector<float> matrix = noise(kInputs * kOutputs, 1);
  const std::vector<float> bias = noise(kOutputs, 2);
  const std::vector<float> in = noise(kFrames * kStride, 3);
  const FrameMatrix packed(matrix, kOutputs);
  const AlignedFloats row = padded_row(bias);
  ASSERT_EQ(packed.row(), 32);
  for_every_target([&] {
    std::vector<float> out(kFrames * packed.row());
    packed.multiply(in.data(), kStride, kFrames, row.data(), out.data(), false);
    packed.multiply(in.data(), kStride, kFrames, row.data(), out.data(), true);
    for (std::ptrdiff_t f = 0; f < kFrames; ++f) {
      for (std::ptrdiff_t o = 0; o < kOutputs; ++o) {
        double product = 0.0;
        for (std::ptrdiff_t i = 0; i < kInputs; ++i) {
          product += double{matrix[o * kInputs + i]} * in[f * kStride + i];
        }
        // Sums of 26 products of at most 1 in float32.
        EXPECT_NEAR(out[f * packed.row() + o], bias[o] + 2 * product, 1e-5);
      }
    }
  });
}

}  // namespace
}  // namespace earpoint::kernels

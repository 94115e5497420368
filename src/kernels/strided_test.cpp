#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/kernels/strided.h>

namespace earpoint::kernels {
namespace {

using Floats = std::vector<float>;

TEST(Strided, ConvolutionSeesItsSamplesAndThePaddingBesides) {
  const Floats in{1, 2, 3, 4, 5, 6};
  // Stride 2, padding 1: four taps; the first output sees 0, 1, 2, 3.
  const Floats out = convolve_strided(in, 1, Floats{1000, 100, 10, 1}, Floats{0.5}, {2, 1});
  EXPECT_EQ(out, (Floats{123.5, 2345.5, 4560.5}));
}

TEST(Strided, ConvolutionSumsItsInputs) {
  const Floats out =
      convolve_strided(Floats{1, 2, 3, 4}, 2, Floats{1, 10, 1, 0}, Floats{0, 7}, {1, 0});
  EXPECT_EQ(out, (Floats{31, 42, 8, 9}));
}

// <convolve(x), y> = <x, transposed(y)> without biases: this is what transposed means.
TEST(Strided, TransposedConvolutionIsTheAdjoint) {
  constexpr int kInputs = 3;
  constexpr int kOutputs = 2;
  const StridedShape shape{5, 2};
  Floats x(kInputs * 20);
  Floats y(kOutputs * 4);
  Floats weight(kOutputs * kInputs * 9);
  // Small whole numbers: their sums are exact.
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<float>(i * 7 % 11) - 5;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = static_cast<float>(i * 5 % 7) - 3;
  for (std::size_t i = 0; i < weight.size(); ++i) weight[i] = static_cast<float>(i * 3 % 13) - 6;
  const Floats forward = convolve_strided(x, kInputs, weight, Floats(kOutputs), shape);
  const Floats backward = convolve_transposed(y, kOutputs, weight, Floats(kInputs), shape);
  ASSERT_EQ(forward.size(), y.size());
  ASSERT_EQ(backward.size(), x.size());
  const float product = std::inner_product(forward.begin(), forward.end(), y.begin(), 0.0F);
  EXPECT_NE(product, 0.0F);
  EXPECT_EQ(product, std::inner_product(backward.begin(), backward.end(), x.begin(), 0.0F));
}

TEST(Strided, TransposedConvolutionAddsItsBias) {
  const Floats out =
      convolve_transposed(Floats{1, 2}, 1, Floats{1, 1, 3, 0, 0, 0}, Floats{10, 20}, {1, 1});
  EXPECT_EQ(out, (Floats{13, 15, 20, 20}));
}

}  // namespace
}  // namespace earpoint::kernels

#include <vector>

#include <gtest/gtest.h>

#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/matrix.h>

namespace earpoint::kernels {
namespace {

using Floats = std::vector<float>;

TEST(Matrix, ProductsAreThoseByHand) {
  const Floats a{1, 2, 3, 4, 5, 6};  // 2 x 3
  const Floats b{1, 0, 2, 1, 0, 3};  // 3 x 2
  Floats out(4);
  multiply(a, b, out, 2, 3, 2);
  EXPECT_EQ(out, (Floats{5, 11, 14, 23}));
  multiply(a, b, out, 2, 3, 2, /*add=*/true);
  EXPECT_EQ(out, (Floats{10, 22, 28, 46}));
  multiply_transposed(a, Floats{1, 2, 0, 0, 1, 3}, out, 2, 3, 2);
  EXPECT_EQ(out, (Floats{5, 11, 14, 23}));
  transposed_multiply(Floats{1, 4, 2, 5, 3, 6}, b, out, 2, 3, 2);
  EXPECT_EQ(out, (Floats{5, 11, 14, 23}));
}

TEST(Matrix, LinearAddsItsBiasToEveryRow) {
  Floats out(4);
  linear(Floats{1, 2, 3, 4}, Floats{1, 1, 0, 2}, Floats{10, 20}, out, 2);
  EXPECT_EQ(out, (Floats{13, 24, 17, 28}));
}

TEST(Matrix, LayerNormScalesEveryRow) {
  Floats out(4);
  layer_norm(Floats{1, 3, -2, 6}, Floats{1, 2}, Floats{0, 1}, out);
  // Of two values one is a standard deviation below the mean and one above, except for epsilon:
  // 5e-6 of a variance of 1, times the weight 2.
  const Floats expected{-1, 3, -1, 3};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(out[i], expected[i], 2e-5);
}

TEST(Matrix, SoftmaxIsOfEveryRowAndDoesNotOverflow) {
  Floats values{0, 0, 1000, 1000 + 1.0986123F};
  softmax_rows(values, 2);
  const Floats expected{0.5, 0.5, 0.25, 0.75};
  // Logarithms near 1000 have steps of 6e-5.
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(values[i], expected[i], 2e-5);
}

TEST(Matrix, SiluIsXTimesItsSigmoid) {
  Floats values{0.0F, 1.0F, -20.0F};
  silu(values);
  EXPECT_EQ(values[0], 0.0F);
  EXPECT_NEAR(values[1], 0.7310586, 1e-6);
  EXPECT_NEAR(values[2], -20 * 2.0611537e-9, 1e-12);
}

}  // namespace
}  // namespace earpoint::kernels

#include "gated_stack.h"

#include "every_target.h"
#include "reference_stack.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>

namespace earpoint::infer {
namespace {

std::vector<float> noise(std::size_t size, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> values(size);
  for (float& value : values) value = static_cast<float>(random.uniform(-1.0, 1.0));
  return values;
}

double largest_error(const std::vector<float>& found, const std::vector<double>& expected) {
  double largest = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double error = std::abs(found[i] - expected[i]);
    if (!(error <= largest)) largest = error;  // also NaN
  }
  return largest;
}

std::vector<DilatedConvolution> powers_of_three(int layers) {
  std::vector<DilatedConvolution> convolutions;
  std::ptrdiff_t dilation = 1;
  for (int i = 0; i < layers; ++i, dilation *= 3) convolutions.push_back({3, dilation, true});
  return convolutions;
}

TEST(GatedStack, AgreesWithTheDefinitionOnEveryTarget) {
  const StackExample example(2, 12, 6, powers_of_three(7), 1);
  const std::vector<float> source = noise(2 * 1700, 2);
  const std::vector<float> z = noise(6, 3);
  const std::vector<double> expected = reference_stack(example.weights, source, z);
  for_every_target([&] {
    GatedStack stack(example.weights, 2);
    std::vector<float> output(source.size());
    stack.run(source, z, output);
    // float32 against double through seven layers with values of order 1.
    EXPECT_LT(largest_error(output, expected), 1e-5);
  });
}

}  // namespace
}  // namespace earpoint::infer

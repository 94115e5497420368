#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/network_testing/oracle_weights.h>
#include <earpoint/people/engine.h>
#include <earpoint/people/weights.h>

namespace earpoint {
namespace {

/// A narrow network with weights by formula.
PeopleWeights small_weights() {
  PeopleWeights weights{{64, 4}, {}, {}};
  for (const auto& [name, shape] : required_tensors(weights.description)) {
    const OracleRandom random(name, 1);
    std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
    const double low = name.ends_with("running_var") ? 0.5 : -0.5;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = random.value(i, low, 1.0);
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  return weights;
}

ImagePlanes noise(int height, int width) {
  ImagePlanes view{3, height, width, {}};
  const OracleRandom random("noise", 2);
  for (std::ptrdiff_t i = 0; i < std::ptrdiff_t{3} * height * width; ++i) {
    view.values.push_back(random.value(i, -0.5, 0.5));
  }
  return view;
}

TEST(PeopleNetwork, LooksAtPicturesOfAnySize) {
  PeopleNetwork network(small_weights());
  const ImagePlanes wide = noise(32, 64);
  const auto first = network.run(wide);
  ASSERT_EQ(first.size(), 5U * 4 * 8);
  const std::vector<float> kept(first.begin(), first.end());
  EXPECT_EQ(network.run(noise(64, 96)).size(), 5U * 8 * 12);
  const auto again = network.run(wide);
  EXPECT_TRUE(std::ranges::equal(again, kept));
}

TEST(PeopleNetwork, GivesTheSameOnAnyNumberOfThreads) {
  PeopleNetwork one(small_weights(), 1);
  PeopleNetwork two(small_weights(), 2);
  const ImagePlanes view = noise(64, 64);
  const auto a = one.run(view);
  const auto b = two.run(view);
  float largest = 0.0F;
  for (const float value : a) largest = std::max(largest, std::abs(value));
  ASSERT_GT(largest, 0.0F);
  ASSERT_EQ(a.size(), b.size());
  // oneDNN may block its sums differently for two threads: float32's rounding over twenty layers.
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-5 * largest);
}

TEST(PeopleNetwork, RefusesViewsThatItsMapsDoNotDivide) {
  PeopleNetwork network(small_weights());
  EXPECT_THROW((void)network.run(noise(40, 64)), std::logic_error);
}

}  // namespace
}  // namespace earpoint

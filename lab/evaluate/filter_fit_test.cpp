#include "filter_fit.h"

#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>

namespace earpoint {
namespace {

std::vector<float> noise(std::size_t samples, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> signal(samples);
  for (float& x : signal) x = static_cast<float>(random.normal());
  return signal;
}

/// output[t] = sum_k taps[k + before] input[lead + t - k], zeros outside
std::vector<float> filtered(const std::vector<float>& input, std::ptrdiff_t lead,
                            std::ptrdiff_t samples, const std::vector<float>& taps,
                            std::ptrdiff_t before) {
  std::vector<float> output(static_cast<std::size_t>(samples));
  for (std::ptrdiff_t t = 0; t < samples; ++t) {
    for (std::ptrdiff_t i = 0; i < std::ssize(taps); ++i) {
      const std::ptrdiff_t place = lead + t - (i - before);
      if (place >= 0 && place < std::ssize(input)) output[t] += taps[i] * input[place];
    }
  }
  return output;
}

void expect_found(std::ptrdiff_t lead) {
  const std::ptrdiff_t samples = 2000;
  const FilterShape shape{.before = 5, .after = 40};
  const std::vector<float> taps = noise(45, 1);
  const std::vector<float> input = noise(static_cast<std::size_t>(lead + samples), 2);
  const std::vector<float> output = filtered(input, lead, samples, taps, shape.before);
  FilterFit fit(shape, lead, samples, {.regularisation = 0.0, .steps = 60});
  const std::vector<float> found = fit.fit(input, output);
  ASSERT_EQ(found.size(), taps.size());
  // Float transforms of 2000 samples; taps are about 1.
  for (std::size_t i = 0; i < taps.size(); ++i) EXPECT_NEAR(found[i], taps[i], 2e-4) << i;
}

TEST(FilterFit, FindsTheFilterThatMadeTheOutput) {
  expect_found(100);  // the input before the output's begin is known
  expect_found(0);    // it was silent: taps reach beyond the input's beginning
}

TEST(FilterFit, OfOneTapIsTheRegularisedQuotient) {
  const std::vector<float> input{1.0F, -2.0F, 0.5F, 3.0F};
  const std::vector<float> output{2.0F, 1.0F, 4.0F, -1.0F};
  FilterFit fit({.before = 0, .after = 1}, 0, 4, {.regularisation = 0.25, .steps = 4});
  // <input, output> = 2 - 2 + 2 - 3 = -1; energy 1 + 4 + 0.25 + 9 = 14.25, plus a quarter of it.
  EXPECT_NEAR(fit.fit(input, output)[0], -1.0 / (1.25 * 14.25), 1e-6);
}

TEST(FilterFit, SilenceGivesZeros) {
  FilterFit fit({.before = 1, .after = 3}, 2, 10, {});
  const std::vector<float> silent(12, 0.0F);
  EXPECT_EQ(fit.fit(silent, noise(10, 3)), std::vector<float>(4, 0.0F));
}

}  // namespace
}  // namespace earpoint

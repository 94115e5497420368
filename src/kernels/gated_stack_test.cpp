#include "reference_stack.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/kernels/gated_stack.h>
#include <earpoint/kernels_testing/every_target.h>

namespace earpoint::kernels {
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

std::vector<DilatedConvolution> powers(std::ptrdiff_t base, int layers, int taps, bool acausal) {
  std::vector<DilatedConvolution> convolutions;
  std::ptrdiff_t dilation = 1;
  for (int i = 0; i < layers; ++i, dilation *= base) {
    convolutions.push_back({taps, dilation, acausal});
  }
  return convolutions;
}

// float32 against double through several layers with values of order 1.
constexpr double kTolerance = 6e-6;

/// Compares with the definition on every instruction set, with two threads.
void expect_agrees(const StackExample& example, std::ptrdiff_t samples) {
  const GatedStackWeights& weights = example.weights;
  const std::vector<float> source =
      noise(static_cast<std::size_t>(samples * weights.audio_channels), 2);
  const std::vector<float> z = noise(weights.conditioning_width, 3);
  const std::vector<double> expected = reference_stack(weights, source, z);
  // With outputs near zero the test would pass for any weights.
  const double scale =
      std::abs(*std::max_element(expected.begin(), expected.end(),
                                 [](double a, double b) { return std::abs(a) < std::abs(b); }));
  ASSERT_GT(scale, 0.02);
  for_every_target([&] {
    GatedStack stack(weights, 2);
    std::vector<float> output(source.size());
    stack.run(source, z, output);
    EXPECT_LT(largest_error(output, expected), kTolerance) << samples << " samples";
  });
}

// Dilations 1 to 2187, so that with 4000 samples every scheme is used: segmented and in time,
// lattices of two and of three points.
TEST(GatedStack, AgreesWithTheDefinitionForEveryScheme) {
  const StackExample example(2, 12, 6, powers(3, 8, 3, true), 1);
  expect_agrees(example, 4000);
  expect_agrees(example, 6000);
}

TEST(GatedStack, AgreesWithTheDefinitionForEveryLength) {
  const StackExample example(2, 5, 3, powers(3, 5, 3, true), 10);
  for (const std::ptrdiff_t samples :
       {1,   2,   3,   4,   5,   15,  16,  17,  31,  32,  33,  80,  81,  82,
        127, 128, 129, 161, 162, 163, 242, 243, 244, 323, 324, 325, 1151}) {
    expect_agrees(example, samples);
  }
}

TEST(GatedStack, AgreesWithTheDefinitionForEveryNumberOfChannels) {
  for (const int channels : {1, 2, 3, 4, 7, 8, 9, 20}) {
    const StackExample example(1 + channels % 3, channels, 4, powers(3, 4, 3, true), 30);
    expect_agrees(example, 300);
  }
}

TEST(GatedStack, AgreesWithTheDefinitionForManyAudioChannels) {
  const StackExample example(11, 6, 4, powers(3, 2, 3, true), 40);
  expect_agrees(example, 100);
}

TEST(GatedStack, AgreesWithTheDefinitionForEveryKernelSize) {
  for (const int taps : {1, 3, 5, 9}) {
    const StackExample example(2, 6, 4, powers(2, 6, taps, true), 50);
    expect_agrees(example, 200);
    expect_agrees(example, 20);
  }
}

TEST(GatedStack, AgreesWithTheDefinitionWhenCausal) {
  for (const int taps : {1, 2, 3, 4}) {
    const StackExample example(2, 6, 4, powers(2, 7, taps, false), 60);
    expect_agrees(example, 200);
    expect_agrees(example, 33);
    expect_agrees(example, 1);
  }
}

// Dilations on both sides of 16, where the order of samples changes.
TEST(GatedStack, AgreesWithTheDefinitionForDilationsOfAnySize) {
  const std::vector<DilatedConvolution> convolutions = {{3, 15, true}, {3, 16, true}, {3, 17, true},
                                                        {3, 2, true},  {3, 31, true}, {3, 33, true},
                                                        {3, 5, true},  {3, 12, true}};
  const StackExample example(2, 6, 4, convolutions, 70);
  for (const std::ptrdiff_t samples : {1919, 1920, 1921, 2100}) expect_agrees(example, samples);
}

TEST(GatedStack, CausalOutputsDoNotSeeTheFuture) {
  const StackExample example(2, 6, 4, powers(2, 6, 2, false), 80);
  const std::vector<float> z = noise(4, 3);
  std::vector<float> source = noise(800, 4);
  GatedStack stack(example.weights, 1);
  std::vector<float> before(source.size());
  std::vector<float> after(source.size());
  stack.run(source, z, before);
  source[200] += 1.0F;
  stack.run(source, z, after);
  EXPECT_TRUE(std::equal(before.begin(), before.begin() + 200, after.begin()));
  EXPECT_NE(before[200], after[200]);
}

TEST(GatedStack, ThreadsDoNotChangeABit) {
  const StackExample example(2, 16, 6, powers(3, 8, 3, true), 90);
  const std::vector<float> source = noise(10000, 2);
  const std::vector<float> z = noise(6, 3);
  for_every_target([&] {
    GatedStack one(example.weights, 1);
    std::vector<float> expected(source.size());
    one.run(source, z, expected);
    for (const int threads : {2, 3, 8}) {
      GatedStack stack(example.weights, threads);
      std::vector<float> output(source.size());
      stack.run(source, z, output);
      EXPECT_EQ(output, expected) << threads << " threads";
    }
  });
}

// What a run leaves in the planes must not reach the next run.
TEST(GatedStack, ForgetsTheClipBefore) {
  const StackExample example(2, 6, 4, powers(3, 6, 3, true), 100);
  const std::vector<float> z = noise(4, 3);
  GatedStack used(example.weights, 2);
  for (const std::size_t samples : {2000U, 777U, 2001U, 100U}) {
    std::vector<float> loud = noise(2 * samples, 5);
    for (float& value : loud) value *= 1000.0F;
    std::vector<float> output(loud.size());
    used.run(loud, z, output);
    const std::vector<float> source = noise(2 * samples, 6);
    used.run(source, z, output);
    GatedStack fresh(example.weights, 2);
    std::vector<float> expected(source.size());
    fresh.run(source, z, expected);
    EXPECT_EQ(output, expected) << samples << " samples";
  }
}

TEST(GatedStack, LoudSoundSaturatesAndStaysFinite) {
  const StackExample example(2, 8, 4, powers(3, 6, 3, true), 110);
  std::vector<float> source = noise(3000, 2);
  for (float& value : source) value *= 1e5F;
  const std::vector<float> z = noise(4, 3);
  for_every_target([&] {
    GatedStack stack(example.weights, 2);
    std::vector<float> output(source.size());
    stack.run(source, z, output);
    EXPECT_TRUE(
        std::all_of(output.begin(), output.end(), [](float v) { return std::isfinite(v); }));
    EXPECT_NE(output, std::vector<float>(source.size())) << "it was written";
  });
}

TEST(GatedStack, RefusesWrongSizes) {
  const StackExample example(2, 4, 4, powers(3, 2, 3, true), 120);
  GatedStack stack(example.weights, 1);
  const std::vector<float> z = noise(4, 3);
  std::vector<float> three(3);
  std::vector<float> four(4);
  std::vector<float> none;
  EXPECT_THROW(stack.run(three, z, three), std::logic_error);
  EXPECT_THROW(stack.run(none, z, none), std::logic_error);
  EXPECT_THROW(stack.run(four, z, three), std::logic_error);
  EXPECT_THROW(stack.run(four, three, four), std::logic_error);
}

}  // namespace
}  // namespace earpoint::kernels

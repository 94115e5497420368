#include "graph.h"

#include "torch_tensor.h"

#include <cmath>
#include <vector>

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/isfinite.h>
#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/train/initial_weights.h>

namespace earpoint {
namespace {

constexpr std::int64_t kSecond = Rt60Description::kWindowSamples;

/// [clips][2][seconds], noise that decays by 60 dB within `t60_s` in every second.
at::Tensor fading_noise(std::int64_t clips, std::int64_t seconds, double t60_s,
                        std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> samples(static_cast<std::size_t>(clips * 2 * seconds * kSecond));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double t = static_cast<double>(i % kSecond) / Rt60Description::kSampleRateHz;
    samples[i] = static_cast<float>(0.1 * random.normal() * std::exp(-6.9 * t / t60_s));
  }
  return to_torch(samples, {clips, 2, seconds * kSecond}, at::kCPU);
}

Rt60Graph make_graph() { return {initial_rt60_weights({4, 1.0}, 3), at::kCPU}; }

double error_s(const Rt60Graph& graph, const at::Tensor& found, const at::Tensor& right) {
  const at::NoGradGuard no_gradients;
  return reverberation_error_s(graph, found, right).item<double>();
}

TEST(Rt60Graph, HearsEverySecondOfEveryEar) {
  const Rt60Graph graph = make_graph();
  const at::Tensor right = fading_noise(1, 2, 1.0, 1);
  EXPECT_EQ(error_s(graph, right, right), 0.0);
  double sum = 0.0;
  const at::Tensor other = fading_noise(1, 2, 0.2, 2);
  for (std::int64_t ear = 0; ear < 2; ++ear) {
    for (std::int64_t second = 0; second < 2; ++second) {
      at::Tensor found = right.clone();
      const auto part = [&](const at::Tensor& sound) {
        return sound.select(1, ear).narrow(1, second * kSecond, kSecond);
      };
      part(found).copy_(part(other));
      const double error = error_s(graph, found, right);
      EXPECT_GT(error, 0.0);
      sum += error;
    }
  }
  // Each of the four has a weight of a quarter; 1e-6 is float32's rounding of times up to some
  // seconds.
  EXPECT_NEAR(sum, error_s(graph, other, right), 1e-6);
}

TEST(Rt60Graph, GradientByTheSoundIsTheSlopeOfTheError) {
  const Rt60Graph graph = make_graph();
  const at::Tensor right = fading_noise(2, 1, 0.3, 1);
  const at::Tensor found = fading_noise(2, 1, 2.0, 2).requires_grad_();
  reverberation_error_s(graph, found, right).backward();
  const at::Tensor gradient = found.grad();
  const double steepness = std::sqrt(gradient.square().sum().item<double>());
  ASSERT_GT(steepness, 0.0);
  // A step along the gradient that is small for quiet bins too, but large against rounding: from
  // 1e-4 to 1e-5 of the sound the slope is the same.
  const double length = 3e-5 * std::sqrt(found.detach().square().sum().item<double>());
  const at::Tensor step = gradient * (length / steepness);
  const double difference =
      error_s(graph, found.detach() + step, right) - error_s(graph, found.detach() - step, right);
  EXPECT_NEAR(difference / (2 * length), steepness, 0.05 * steepness);
}

TEST(Rt60Graph, SilenceHasAGradient) {
  const Rt60Graph graph = make_graph();
  at::Tensor found = fading_noise(1, 1, 0.5, 2);
  found.select(1, 0).zero_();
  found.narrow(2, 0, kSecond / 2).zero_();
  found.requires_grad_();
  reverberation_error_s(graph, found, fading_noise(1, 1, 1.0, 1)).backward();
  EXPECT_TRUE(at::isfinite(found.grad()).all().item<bool>());
}

}  // namespace
}  // namespace earpoint

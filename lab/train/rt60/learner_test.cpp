#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/rt60/description.h>
#include <earpoint/rt60/engine.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/rt60_learner.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kSamples = Rt60Description::kWindowSamples;

/// Noise with several reverberation times, and those times.
TrainingBatch fading_noise(int clips, std::uint64_t seed) {
  std::vector<TrainingExample> examples;
  for (int clip = 0; clip < clips; ++clip) {
    RandomStream random(seed, {static_cast<std::uint64_t>(clip)});
    const double t60_s = 0.2 + 0.2 * clip;
    std::vector<float> sound(kSamples);
    for (std::ptrdiff_t i = 0; i < kSamples; ++i) {
      const double t = static_cast<double>(i) / Rt60Description::kSampleRateHz;
      sound[i] = static_cast<float>(0.1 * random.normal() * std::exp(-6.9 * t / t60_s));
    }
    examples.push_back(rt60_example(std::move(sound), t60_s));
  }
  return join(examples);
}

TEST(Rt60Learner, EstimatesAsTheEngineDoes) {
  for (const std::optional<double> rms : {std::optional<double>(), std::optional<double>(1.0)}) {
    const Rt60EstimatorWeights weights = initial_rt60_weights({4, rms}, 3);
    Rt60Learner learner(weights);
    const TrainingBatch batch = fading_noise(3, 1);
    learner.compute_gradients(batch);  // so that the batch norms' statistics are not 0 and 1
    const std::vector<double> found = learner.estimate_s(batch);
    Rt60Estimator engine(learner.weights());
    for (std::size_t clip = 0; clip < found.size(); ++clip) {
      const auto second = std::span(batch.source).subspan(clip * kSamples, kSamples);
      // Two implementations of eighteen float32 layers that sum in different order.
      EXPECT_NEAR(engine.estimate_second_s(second), found[clip], 1e-4);
    }
    EXPECT_NE(found[0], found[1]);
  }
}

TEST(Rt60Learner, GradientIsTheSlopeOfTheLoss) {
  Rt60EstimatorWeights weights = initial_rt60_weights({2, 1.0}, 5);
  const TrainingBatch batch = fading_noise(2, 2);
  Rt60Learner learner(weights);
  learner.compute_gradients(batch);
  const std::map<std::string, Tensor> gradients = learner.gradients();
  for (const char* name : {"predictor.0.weight", "feature_extraction.7.1.conv2.weight"}) {
    const auto gradient = gradients.at(name).as<float>();
    const auto at = std::ranges::max_element(
        gradient, [](float a, float b) { return std::abs(a) < std::abs(b); });
    const auto loss_with = [&](float step) {
      Rt60EstimatorWeights moved = weights;
      const auto values = moved.at(name).as<float>();
      std::vector<float> changed(values.begin(), values.end());
      changed[static_cast<std::size_t>(at - gradient.begin())] += step;
      moved.tensors[name] = make_tensor<float>(changed, moved.at(name).shape);
      return Rt60Learner(moved).compute_gradients(batch);
    };
    constexpr float kStep = 1e-2F;
    const double slope = (loss_with(kStep) - loss_with(-kStep)) / (2.0 * kStep);
    // Second-order terms of a step that is large against float32's rounding.
    EXPECT_NEAR(slope, *at, 0.05 * std::abs(*at)) << name;
  }
}

TEST(Rt60Learner, LearnsHowFastNoiseFades) {
  Rt60Learner learner(initial_rt60_weights({4, 1.0}, 7));
  const double before = learner.compute_gradients(fading_noise(4, 100));
  for (std::uint64_t step = 0; step < 60; ++step) {
    learner.compute_gradients(fading_noise(4, step));
    learner.apply_gradients(3e-3);
  }
  double error = 0.0;
  for (const double of_clip : learner.errors(fading_noise(4, 200))) error += of_clip / 4;
  // At first it answers about half a second whatever it hears: `before` is near the error of the
  // best such answer, 0.2 s for the four times.
  EXPECT_LT(error, 0.5 * before);
}

TEST(Rt60Learner, GoesOnFromItsCheckpointAsIfUnbroken) {
  Rt60Learner whole(initial_rt60_weights({2, 1.0}, 9));
  const auto learn = [](Rt60Learner& learner, std::uint64_t step) {
    const double loss = learner.compute_gradients(fading_noise(3, step));
    learner.apply_gradients(1e-3);
    return loss;
  };
  for (std::uint64_t step = 0; step < 3; ++step) learn(whole, step);
  Rt60Learner resumed = Rt60Learner::from_checkpoint(whole.checkpoint(), "x");
  EXPECT_EQ(resumed.steps(), 3);
  for (std::uint64_t step = 3; step < 6; ++step)
    EXPECT_EQ(learn(resumed, step), learn(whole, step));
}

}  // namespace
}  // namespace earpoint

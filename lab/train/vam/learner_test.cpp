#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/vam_learner.h>
#include <earpoint/vam/description.h>
#include <earpoint/vam/engine.h>
#include <earpoint/vam/weights.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kSamples = 1000;

VamDescription small() {
  VamDescription d;
  d.image_width_px = d.image_height_px = 64;
  d.trunk_channels = 2;
  d.strides = {5, 4, 2};
  d.channels = {4, 6, 8};
  d.heads = 2;
  d.feed_forward_width = 12;
  d.kernel_size = 5;
  return d;
}

/// Noise, quieter and with a level difference at the target.
PairSample pair(std::uint64_t seed) {
  RandomStream random(seed);
  PairSample sample;
  sample.source = Waveform(2, kSamples, 16000);
  sample.target = Waveform(2, kSamples, 16000);
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 0; i < kSamples; ++i) {
      sample.source.channel(ear)[i] = static_cast<float>(0.2 * random.normal());
      sample.target.channel(ear)[i] = (ear == 0 ? 0.3F : 0.8F) * sample.source.channel(ear)[i];
    }
  }
  Image picture(32, 24, 3);
  for (auto& value : picture.pixels()) value = static_cast<std::uint8_t>(random.index(256));
  sample.picture = std::make_shared<const Image>(std::move(picture));
  sample.source_from_target = {{random.uniform(-2, 2), random.uniform(-2, 2), 0.0},
                               quaternion_from_euler({.yaw_rad = random.uniform(-3, 3)})};
  return sample;
}

TrainingBatch pairs(std::uint64_t count) {
  std::vector<TrainingExample> examples;
  for (std::uint64_t i = 0; i < count; ++i) examples.push_back(vam_example(small(), pair(i)));
  return join(examples);
}

/// A learner after two steps, so that layers that start at zero have an effect.
VamLearner stepped_learner(const TrainingBatch& batch) {
  VamLearner learner(initial_vam_weights(small(), 3));
  for (int step = 0; step < 2; ++step) {
    learner.compute_gradients(batch);
    learner.apply_gradients(0.03);
  }
  return learner;
}

TEST(VamLearner, PredictsWhatTheEngineSynthesizes) {
  const TrainingBatch batch = pairs(2);
  VamLearner learner = stepped_learner(batch);
  const std::vector<float> predicted = learner.predict(batch);
  Vam engine(learner.weights(), 1);
  const std::size_t size = predicted.size() / 2;
  for (std::size_t clip = 0; clip < 2; ++clip) {
    const PairSample sample = pair(clip);
    const TrainingExample example = vam_example(small(), sample);
    std::vector<float> output(size);
    engine.synthesize(sample.source.planar(), engine.image_map(*sample.picture),
                      example.inputs.at(std::string(kVamPoseInput)), output);
    double largest = 0.0;
    double loudest = 0.0;
    for (std::size_t i = 0; i < size; ++i) {
      const double wanted = predicted[clip * size + i];
      largest = std::max(largest, std::abs(output[i] - wanted));
      loudest = std::max(loudest, std::abs(wanted));
    }
    EXPECT_LT(largest, 1e-4);  // float32 in another order
    EXPECT_GT(loudest, 0.05);
  }
}

TEST(VamLearner, HearsPictureAndPose) {
  TrainingBatch batch = pairs(2);
  VamLearner learner = stepped_learner(batch);
  const std::vector<float> original = learner.predict(batch);
  TrainingBatch elsewhere = batch;
  for (float& x : elsewhere.inputs.at(std::string(kVamPoseInput))) x = -x;
  EXPECT_NE(learner.predict(elsewhere), original);
  for (float& x : batch.pictures) x = 1.0F - x;
  EXPECT_NE(learner.predict(batch), original);
}

TEST(VamLearner, GradientIsTheSlopeOfTheLoss) {
  const TrainingBatch batch = pairs(2);
  VamLearner learner = stepped_learner(batch);
  const VamWeights weights = learner.weights();
  learner.compute_gradients(batch);
  const std::map<std::string, Tensor> gradients = learner.gradients();
  for (const char* name :
       {"output.weight", "decoder.0.weight", "encoder.0.weight", "blocks.1.cross.value.weight",
        "blocks.0.convolution.depthwise.weight", "image_position", "sound_projection.weight"}) {
    const auto gradient = gradients.at(name).as<float>();
    const auto at = std::ranges::max_element(
        gradient, [](float a, float b) { return std::abs(a) < std::abs(b); });
    const auto loss_with = [&](float step) {
      VamWeights moved = weights;
      const auto values = moved.at(name).as<float>();
      std::vector<float> changed(values.begin(), values.end());
      changed[static_cast<std::size_t>(at - gradient.begin())] += step;
      moved.tensors[name] = make_tensor<float>(changed, moved.at(name).shape);
      return VamLearner(moved).compute_gradients(batch);
    };
    constexpr float kStep = 1e-2F;
    const double slope = (loss_with(kStep) - loss_with(-kStep)) / (2.0 * kStep);
    // The loss is a mean of absolute values: a step over their kinks bends its slope, and rounding
    // of a loss near 1 is 1e-7 of it.
    EXPECT_NEAR(slope, *at, 0.1 * std::abs(*at) + 2e-5) << name;
  }
}

TEST(VamLearner, BeginsAsTheIdentityAndLearnsOnePair) {
  const TrainingBatch batch = pairs(1);
  VamLearner learner(initial_vam_weights(small(), 5));
  const std::vector<float> first = learner.predict(batch);
  double difference = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    difference = std::max<double>(difference, std::abs(first[i] - batch.source[i]));
  }
  EXPECT_LT(difference, 1e-6);
  const double before = learner.errors(batch)[0];
  for (int step = 0; step < 60; ++step) {
    learner.compute_gradients(batch);
    learner.apply_gradients(0.01);
  }
  EXPECT_LT(learner.compute_gradients(batch), 0.25 * before);
}

TEST(VamLearner, GoesOnFromItsCheckpointAsIfUnbroken) {
  const TrainingBatch batch = pairs(2);
  VamLearner whole = stepped_learner(batch);
  VamLearner resumed = VamLearner::from_checkpoint(whole.checkpoint(), "x");
  EXPECT_EQ(resumed.steps(), 2);
  for (int step = 0; step < 2; ++step) {
    EXPECT_EQ(resumed.compute_gradients(batch), whole.compute_gradients(batch));
    resumed.apply_gradients(1e-3);
    whole.apply_gradients(1e-3);
  }
}

}  // namespace
}  // namespace earpoint

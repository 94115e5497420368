#include <cmath>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/vigas_learner.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {
namespace {

ViGasDescription network(int blocks, int layers, int channels) {
  ViGasDescription d;
  d.pose_encoding = PoseEncoding::full;
  d.box_encoding = BoxEncoding::corners;
  d.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}, {"bboxes", 4}};
  d.fusion_width = 64;
  d.conditioning_width = 64;
  d.blocks = blocks;
  d.layers_per_block = layers;
  d.channels = channels;
  return d;
}

/// Two clips of noise at the level of loud speech, seen from two poses.
TrainingBatch noise_batch() {
  RandomStream random(3);
  TrainingBatch batch;
  batch.clips = 2;
  for (int i = 0; i < 2 * 2 * 4000; ++i) {
    batch.source.push_back(static_cast<float>(0.1 * random.normal()));
  }
  batch.inputs["tgt_pose"] = {1.0F, -2.0F, 0.1F, -3.0F, 0.5F, 0.0F};
  batch.inputs["tgt_rotation"] = {0, 1, 0, 1, 0, 1, 0.7F, -0.7F, 0, 1, 0, 1};
  batch.inputs["bboxes"] = {0.1F, 0.2F, 0.3F, 0.9F, 0, 0, 0, 0};
  return batch;
}

/// Size of the output's difference from the input, relative to the input.
double change(const ViGasDescription& description, std::uint64_t seed) {
  const TrainingBatch batch = noise_batch();
  ViGasLearner learner(identity_vigas_weights(description, seed));
  const std::vector<float> output = learner.predict(batch);
  double difference = 0.0;
  double energy = 0.0;
  for (std::size_t i = 0; i < output.size(); ++i) {
    difference += std::pow(static_cast<double>(output[i]) - batch.source[i], 2.0);
    energy += std::pow(static_cast<double>(batch.source[i]), 2.0);
  }
  return std::sqrt(difference / energy);
}

TEST(IdentityWeights, GiveBackTheInputNearlyUnchanged) {
  // Leakage adds 5 %. The condition moves the gates by a tenth of a vector whose size varies by
  // half between seeds, which changes gains by half as much. The change must not be zero, either.
  for (const std::uint64_t seed : {1, 2, 3}) {
    EXPECT_LT(change(network(1, 10, 32), seed), 0.12) << seed;
    EXPECT_LT(change(network(3, 10, 64), seed), 0.12) << seed;
    EXPECT_GT(change(network(1, 10, 32), seed), 1e-3) << seed;
  }
}

TEST(IdentityWeights, EveryKindOfInputCountsAlike) {
  ViGasDescription d = network(1, 4, 16);
  d.inputs.push_back({"visual_feat", 72});
  const ViGasWeights weights = identity_vigas_weights(d, 1);
  const std::span<const float> fusion = weights.at("fusion.0.weight").as<float>();
  std::vector<double> energy;  // of each kind of input in the hidden layer
  std::size_t column = 0;
  for (const ConditioningInput& input : d.inputs) {
    const double spread = input.name == "tgt_pose" ? 2.0 : 1.0;
    double sum = 0.0;
    for (int i = 0; i < input.width; ++i, ++column) {
      for (std::size_t row = 0; row < static_cast<std::size_t>(d.fusion_width); ++row) {
        sum += std::pow(spread * fusion[row * (3 + 6 + 4 + 72) + column], 2.0);
      }
    }
    energy.push_back(sum);
  }
  // Sums of 192 squares or more: a standard error of 10 % each; 40 % is three times that of a
  // ratio.
  for (const double sum : energy) EXPECT_NEAR(sum / energy[0], 1.0, 0.4);
}

TEST(IdentityWeights, FirstGradientReachesWhatTheConditionComesFrom) {
  ViGasLearner learner(identity_vigas_weights(network(1, 4, 16), 1));
  TrainingBatch batch = noise_batch();
  batch.target.assign(batch.source.size(), 0.05F);
  learner.compute_gradients(batch);
  const auto gradients = learner.gradients();
  for (const char* name :
       {"fusion.0.weight", "fusion.2.weight", "input.weight",
        "hyperconv_wavenet.layers.2.conv.w_f.weight", "hyperconv_wavenet.layers.0.conv.w_g.weight",
        "hyperconv_wavenet.layers.1.residual.weight"}) {
    double sum = 0.0;
    for (const float value : gradients.at(name).as<float>()) sum += std::abs(value);
    EXPECT_GT(sum, 0.0) << name;
  }
}

}  // namespace
}  // namespace earpoint

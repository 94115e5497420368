#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/synthesizer.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {
namespace {

/// A small network with a real image encoder and random weights.
ViGasWeights make_weights() {
  ViGasDescription description;
  description.image_encoder = ImageEncoderDescription{64, 64, 2};
  description.inputs = {{"visual_feat", description.image_encoder->feature_width()},
                        {"tgt_pose", 3},
                        {"tgt_rotation", 2},
                        {"bboxes", 4}};
  description.window_samples = 4000;
  description.fusion_width = 16;
  description.conditioning_width = 8;
  description.channels = 8;
  description.blocks = 1;
  description.layers_per_block = 3;
  description.highpass_cutoff_hz = 80.0;
  check_description(description, "test");

  ViGasWeights weights;
  weights.description = description;
  RandomStream random(1);
  for (const auto& [name, shape] : required_tensors(description)) {
    std::int64_t elements = 1;
    for (const std::int64_t size : shape) elements *= size;
    std::vector<float> values(static_cast<std::size_t>(elements));
    // A batch norm's variance must be positive.
    const double low = name.ends_with("running_var") ? 0.5 : -0.2;
    for (float& value : values) value = static_cast<float>(random.uniform(low, low + 0.4));
    weights.tensors.emplace(name, make_tensor(std::span<const float>(values), shape));
  }
  return weights;
}

Observation make_observation(const Image& picture) {
  Observation observation;
  observation.sound = Waveform(2, 4000, 16000);
  RandomStream random(2);
  for (float& sample : observation.sound.planar()) sample = static_cast<float>(random.normal());
  observation.picture = std::make_shared<const Image>(picture);
  observation.speaker_box = Box{0.1, 0.2, 0.3, 0.4};
  return observation;
}

TEST(ViGasSynthesizer, GivesWhatTheNetworkGivesForTheEncodedInputs) {
  const ViGasWeights weights = make_weights();
  const Image picture(96, 54, 3, 77);
  const Observation observation = make_observation(picture);
  const Pose target{{1, -0.5, 0}, quaternion_from_euler({.yaw_rad = 0.7})};

  ViGasSynthesizer synthesizer(weights, "test", 1);
  synthesizer.observe(observation);
  const Waveform result = synthesizer.synthesize(target);

  ViGas network(weights, 1);
  const std::vector<float> feature = network.image_feature(picture);
  const EncodedPose pose = encode_pose(PoseEncoding::soundspaces, target);
  const std::vector<float> box = encode_box(BoxEncoding::soundspaces, *observation.speaker_box);
  const std::vector<ConditioningValues> inputs = {{"visual_feat", feature},
                                                  {"tgt_pose", pose.tgt_pose},
                                                  {"tgt_rotation", pose.tgt_rotation},
                                                  {"bboxes", box}};
  std::vector<float> fused(8);
  network.fuse(inputs, fused);
  std::vector<float> expected(8000);
  network.synthesize(observation.sound.planar(), fused, expected);
  ASSERT_TRUE(std::equal(expected.begin(), expected.end(), result.planar().begin()));
  // Another target gives another sound: the pose reaches the network.
  const Waveform other = synthesizer.synthesize(Pose{});
  EXPECT_FALSE(std::equal(expected.begin(), expected.end(), other.planar().begin()));
}

TEST(ViGasSynthesizer, LooksAgainWhereThePictureIsAnother) {
  const Observation bright = make_observation(Image(96, 54, 3, 200));
  Observation dark = bright;
  dark.picture = std::make_shared<const Image>(96, 54, 3, std::uint8_t{10});
  const auto heard = [&](ViGasSynthesizer& synthesizer, const Observation& observation) {
    synthesizer.observe(observation);
    const Waveform result = synthesizer.synthesize(Pose{});
    return std::vector<float>(result.planar().begin(), result.planar().end());
  };
  const auto at_first = [&](const Observation& observation) {
    ViGasSynthesizer synthesizer(make_weights(), "test", 1);
    return heard(synthesizer, observation);
  };
  EXPECT_NE(at_first(bright), at_first(dark));
  ViGasSynthesizer synthesizer(make_weights(), "test", 1);
  for (const Observation& observation : {bright, bright, dark, bright}) {
    EXPECT_EQ(heard(synthesizer, observation), at_first(observation));
  }
}

TEST(ViGasSynthesizer, StatesItsWindowsAndItsAmbientCutoff) {
  const ViGasSynthesizer synthesizer(make_weights(), "test", 1);
  const WindowShape shape = synthesizer.window_shape(48000);
  EXPECT_EQ(shape.sample_rate_hz, 16000);
  EXPECT_EQ(shape.samples, 4000);
  EXPECT_EQ(shape.overlap, 1000);
  EXPECT_EQ(synthesizer.ambient_cutoff_hz(), 80.0);
  EXPECT_EQ(synthesizer.picture_use(), PictureUse::always);
}

TEST(ViGasSynthesizer, ASpeakerOutOfSightIsABoxOfZeros) {
  ViGasSynthesizer synthesizer(make_weights(), "test", 1);
  EXPECT_TRUE(synthesizer.needs_speaker_track());
  const auto with_box = [&](const std::optional<Box>& box) {
    Observation observation = make_observation(Image(64, 64, 3, 90));
    observation.speaker_box = box;
    synthesizer.observe(observation);
    const Waveform result = synthesizer.synthesize(Pose{});
    return std::vector<float>(result.planar().begin(), result.planar().end());
  };
  const std::vector<float> out_of_sight = with_box(std::nullopt);
  EXPECT_EQ(out_of_sight, with_box(Box{}));
  EXPECT_NE(out_of_sight, with_box(Box{0.2, 0.2, 0.5, 0.9}));
}

TEST(ViGasSynthesizer, SaysThatAReplayNetworkKnowsTheRoomsAxes) {
  ViGasWeights weights = make_weights();
  EXPECT_TRUE(ViGasSynthesizer(weights, "test", 1).warnings({}).empty());
  weights.description.pose_encoding = PoseEncoding::replay;
  weights.description.inputs = {{"tgt_pose", 3}, {"bboxes", 4}};
  weights.description.image_encoder.reset();
  RandomStream random(1);
  weights.tensors = random_tensors(required_tensors(weights.description), random, -0.2, 0.2);
  const auto warnings = ViGasSynthesizer(weights, "test", 1).warnings({});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("x axis"), std::string::npos) << warnings[0];
}

}  // namespace
}  // namespace earpoint

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/vam/description.h>
#include <earpoint/vam/synthesizer.h>
#include <earpoint/vam/weights.h>

namespace earpoint {
namespace {

VamWeights make_weights(int ears = 2) {
  VamDescription d;
  d.audio_channels = ears;
  d.image_width_px = d.image_height_px = 64;
  d.trunk_channels = 2;
  d.strides = {5, 4};
  d.channels = {4, 6};
  d.heads = 2;
  d.feed_forward_width = 8;
  d.window_samples = 4000;
  d.highpass_cutoff_hz = 80.0;
  VamWeights weights{d, {}, {}};
  RandomStream random(1);
  for (const auto& [name, shape] : required_tensors(d)) {
    std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
    // A batch norm's variance must be positive. The picture must have an effect after the trunk.
    const double size = name.starts_with("visual_encoder.") ? 1.6 : 0.4;
    const double low = name.ends_with("running_var") ? 0.5 : -size / 2;
    for (float& value : values) value = static_cast<float>(random.uniform(low, low + size));
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  return weights;
}

Observation make_observation(const Image& picture) {
  Observation observation;
  observation.sound = Waveform(2, 4010, 16000);  // not a whole number of tokens
  RandomStream random(2);
  for (float& sample : observation.sound.planar()) sample = static_cast<float>(random.normal());
  observation.picture = std::make_shared<const Image>(picture);
  return observation;
}

TEST(VamSynthesizer, GivesWhatTheNetworkGivesForTheEncodedPose) {
  const Image picture(96, 54, 3, 77);
  const Observation observation = make_observation(picture);
  VamSynthesizer synthesizer(make_weights(), "test", 1);
  synthesizer.observe(observation);
  const Waveform result = synthesizer.synthesize({{1, -0.5, 0.25}, Quaternion{}});

  Vam network(make_weights(), 1);
  const std::vector<float> pose = {1, -0.5, 0.25, 0, 1, 0, 1, 0, 1};
  std::vector<float> expected(8020);
  network.synthesize(observation.sound.planar(), network.image_map(picture), pose, expected);
  ASSERT_TRUE(std::equal(expected.begin(), expected.end(), result.planar().begin()));
  const Waveform other = synthesizer.synthesize(Pose{});
  EXPECT_FALSE(std::equal(expected.begin(), expected.end(), other.planar().begin()));
}

TEST(VamSynthesizer, LooksAgainWhereThePictureIsAnother) {
  Image picture(96, 54, 3, 200);
  const Observation bright = make_observation(picture);
  // Only half of it, as the trunk's norms make all uniform pictures equal.
  std::fill_n(picture.pixels().begin(), picture.pixels().size() / 2, std::uint8_t{10});
  Observation dark = bright;
  dark.picture = std::make_shared<const Image>(picture);
  const auto heard = [&](VamSynthesizer& synthesizer, const Observation& observation) {
    synthesizer.observe(observation);
    const Waveform result = synthesizer.synthesize(Pose{});
    return std::vector<float>(result.planar().begin(), result.planar().end());
  };
  const auto at_first = [&](const Observation& observation) {
    VamSynthesizer synthesizer(make_weights(), "test", 1);
    return heard(synthesizer, observation);
  };
  EXPECT_NE(at_first(bright), at_first(dark));
  VamSynthesizer synthesizer(make_weights(), "test", 1);
  for (const Observation& observation : {bright, bright, dark, bright}) {
    EXPECT_EQ(heard(synthesizer, observation), at_first(observation));
  }
}

TEST(VamSynthesizer, StatesItsWindowsAndNeedsNoBox) {
  const VamSynthesizer synthesizer(make_weights(), "test", 1);
  const WindowShape shape = synthesizer.window_shape(48000);
  EXPECT_EQ(shape.sample_rate_hz, 16000);
  EXPECT_EQ(shape.samples, 4000);
  EXPECT_EQ(synthesizer.ambient_cutoff_hz(), 80.0);
  EXPECT_EQ(synthesizer.picture_use(), PictureUse::always);
}

TEST(VamSynthesizer, IsMadeOfItsWeightFile) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / "vam_synthesizer_test.safetensors";
  write_safetensors(path, to_weight_file(make_weights()));
  const auto synthesizer = make_synthesizer(path.string(), {});
  EXPECT_NE(dynamic_cast<VamSynthesizer*>(synthesizer.get()), nullptr);
  write_safetensors(path, to_weight_file(make_weights(1)));
  EXPECT_THROW((void)make_synthesizer(path.string(), {}), InputError);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace earpoint

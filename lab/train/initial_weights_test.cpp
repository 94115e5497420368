#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

ViGasDescription small_with_picture() {
  ViGasDescription d;
  d.image_encoder = ImageEncoderDescription{32, 32, 8};
  d.inputs = {{"visual_feat", 8}, {"tgt_pose", 3}, {"tgt_rotation", 2}, {"bboxes", 4}};
  d.fusion_width = 16;
  d.conditioning_width = 8;
  d.blocks = 1;
  d.layers_per_block = 2;
  return d;
}

double largest(const Tensor& tensor) {
  double found = 0.0;
  for (const float value : tensor.as<float>()) found = std::max<double>(found, std::abs(value));
  return found;
}

/// The largest of thousands of uniform numbers is within a few per cent of the bound.
void expect_bound(const ViGasWeights& weights, const std::string& name, double bound) {
  EXPECT_LE(largest(weights.at(name)), bound * (1 + 1e-6)) << name;  // rounding to float
  EXPECT_GE(largest(weights.at(name)), 0.95 * bound) << name;
}

TEST(InitialWeights, AreThoseOfTheReleasedCode) {
  const ViGasWeights weights = initial_vigas_weights(small_with_picture(), 1);
  const std::string layer = "hyperconv_wavenet.layers.0.";
  for (const char* gate : {"w_f", "w_g", "v_f", "v_g"}) {
    EXPECT_EQ(largest(weights.at(layer + "conv." + gate + ".weight")), 0.0);
    expect_bound(weights, layer + "conv." + gate + ".bias", std::sqrt(6.0 / 192));
  }
  for (const std::string name : {"skip", "residual"}) {
    expect_bound(weights, layer + name + ".weight", std::sqrt(6.0 / 64));
    expect_bound(weights, layer + name + ".bias", 1.0 / 8);
  }
  expect_bound(weights, "input.weight", std::sqrt(3.0));
  expect_bound(weights, "output_net.1.first.weight", std::sqrt(6.0 / 64));
  expect_bound(weights, "output_net.1.second.weight", 1.0 / 8);
  expect_bound(weights, "fusion.0.weight", 1.0 / std::sqrt(17.0));
  expect_bound(weights, "conv1x1.0.weight", 1.0 / std::sqrt(512.0));
  EXPECT_EQ(weights.at("visual_encoder.1.weight").as<float>()[5], 1.0F);
  EXPECT_EQ(weights.at("visual_encoder.1.running_var").as<float>()[5], 1.0F);
  EXPECT_EQ(largest(weights.at("visual_encoder.1.running_mean")), 0.0);
}

TEST(InitialWeights, TrunkKeepsTheVarianceOfGradients) {
  const ViGasWeights weights = initial_vigas_weights(small_with_picture(), 1);
  double sum = 0.0;
  const auto values = weights.at("visual_encoder.5.0.conv1.weight").as<float>();
  for (const float value : values) sum += static_cast<double>(value) * value;
  const double expected = 2.0 / (128 * 9);
  // 73 728 draws: the variance has a standard error of sqrt(2 / 73 728), half a per cent; four
  // times that.
  EXPECT_NEAR(sum / static_cast<double>(values.size()), expected, 0.02 * expected);
}

TEST(InitialWeights, DependOnTheSeedAlone) {
  const ViGasWeights first = initial_vigas_weights(small_with_picture(), 7);
  EXPECT_TRUE(first.tensors == initial_vigas_weights(small_with_picture(), 7).tensors);
  EXPECT_FALSE(first.tensors == initial_vigas_weights(small_with_picture(), 8).tensors);
}

TEST(ImageTrunk, TakesTorchvisionsNamesAndNamesWhatIsMissing) {
  const auto path = std::filesystem::path(testing::TempDir()) / "trunk.safetensors";
  ViGasWeights weights = initial_vigas_weights(small_with_picture(), 1);
  const ViGasWeights other = initial_vigas_weights(small_with_picture(), 2);
  SafetensorsFile trunk;
  const std::pair<std::string, std::string> renamed[] = {
      {"visual_encoder.0.", "conv1."},  {"visual_encoder.1.", "bn1."},
      {"visual_encoder.4.", "layer1."}, {"visual_encoder.5.", "layer2."},
      {"visual_encoder.6.", "layer3."}, {"visual_encoder.7.", "layer4."}};
  for (const auto& [ours, theirs] : renamed) {
    for (const auto& [name, tensor] : other.tensors) {
      if (name.starts_with(ours)) trunk.tensors[theirs + name.substr(ours.size())] = tensor;
    }
  }
  write_safetensors(path, trunk);
  load_image_trunk(path, weights);
  EXPECT_EQ(weights.at("visual_encoder.7.1.conv2.weight"),
            other.at("visual_encoder.7.1.conv2.weight"));
  EXPECT_FALSE(weights.at("fusion.0.weight") == other.at("fusion.0.weight"));

  trunk.tensors.erase("layer3.0.downsample.0.weight");
  write_safetensors(path, trunk);
  try {
    load_image_trunk(path, weights);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("layer3.0.downsample.0.weight"), std::string::npos);
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace earpoint

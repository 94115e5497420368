#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/error.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/vam/description.h>
#include <earpoint/vam/weights.h>

namespace earpoint {
namespace {

using Shape = std::vector<std::int64_t>;

std::string refusal_with(const std::string& key, const nlohmann::json& value) {
  nlohmann::json json = nlohmann::json::parse(to_json(VamDescription{}));
  json[key] = value;
  try {
    (void)vam_description_from_json(json.dump(), "x");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(VamDescription, JsonRoundTrips) {
  VamDescription d;
  d.highpass_cutoff_hz = 80.0;
  d.strides = {4, 4};
  d.channels = {6, 8};
  d.trunk_channels = 16;
  const std::string json = to_json(d);
  EXPECT_EQ(to_json(vam_description_from_json(json, "x")), json);
}

TEST(VamDescription, ImpossibleNetworksAreRefusedByName) {
  EXPECT_EQ(refusal_with("blocks", 3), "accepted");
  EXPECT_NE(refusal_with("heads", 5).find("heads"), std::string::npos);
  EXPECT_NE(refusal_with("kernel_size", 4).find("kernel_size"), std::string::npos);
  EXPECT_NE(refusal_with("strides", {5, 4}).find("number of channels"), std::string::npos);
  EXPECT_NE(refusal_with("channels", {1, 2, 3, "many"}).find("channels"), std::string::npos);
  EXPECT_NE(refusal_with("network", "vigas").find("expected 'vam'"), std::string::npos);
  EXPECT_NE(refusal_with("colour", 1).find("colour"), std::string::npos);
}

TEST(VamDescription, LevelsOfTheEncoderFitThoseOfTheDecoder) {
  const VamDescription d;
  EXPECT_EQ(d.token_samples(), 160);
  EXPECT_EQ(d.image_tokens(), 64);
  const auto shapes = required_tensors(d);
  EXPECT_EQ(shapes.at("encoder.0.weight"), (Shape{32, 2, 9}));
  EXPECT_EQ(shapes.at("encoder.3.weight"), (Shape{192, 128, 4}));
  EXPECT_EQ(shapes.at("decoder.3.weight"), (Shape{384, 128, 4}));
  EXPECT_EQ(shapes.at("decoder.0.weight"), (Shape{64, 16, 9}));
  EXPECT_EQ(shapes.at("output.weight"), (Shape{2, 18, 7}));
  EXPECT_EQ(shapes.at("image_projection.weight"), (Shape{192, 521}));
}

TEST(VamWeights, WeightFileReadsBack) {
  VamWeights weights;
  weights.description.trunk_channels = 1;
  weights.description.strides = {2};
  weights.description.channels = {4};
  weights.description.feed_forward_width = 4;
  for (const auto& [name, shape] : required_tensors(weights.description)) {
    const std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()), 0.5F);
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  SafetensorsFile file = to_weight_file(weights);
  EXPECT_EQ(network_kind(file, "x"), NetworkKind::vam);
  EXPECT_EQ(vam_weights(file, "x").tensors, weights.tensors);
  file.tensors.erase("blocks.1.cross.key.bias");
  EXPECT_THROW((void)vam_weights(file, "x"), InputError);
}

}  // namespace
}  // namespace earpoint

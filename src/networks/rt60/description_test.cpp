#include <string>

#include <gtest/gtest.h>

#include <earpoint/network/network_kind.h>
#include <earpoint/network_testing/refusal.h>
#include <earpoint/rt60/description.h>
#include <earpoint/rt60/weights.h>

namespace earpoint {
namespace {

TEST(Rt60Description, JsonRoundTrips) {
  const Rt60Description d{16, 0.5};
  const Rt60Description read = rt60_description_from_json(to_json(d), "x");
  EXPECT_EQ(read.channels, 16);
  EXPECT_EQ(read.input_rms, 0.5);
  EXPECT_FALSE(rt60_description_from_json(to_json(Rt60Description{}), "x").input_rms.has_value());
}

TEST(Rt60Description, WithoutAWidthIsOfTheReleasedNetwork) {
  const Rt60Description read = rt60_description_from_json(
      R"({"format":1,"network":"rt60_estimator","sample_rate_hz":16000})", "x");
  EXPECT_EQ(read.channels, 64);
  EXPECT_FALSE(read.input_rms.has_value());
}

TEST(Rt60Description, WrongValuesAreNamed) {
  const auto said = [](const std::string& channels, const std::string& rms) {
    const std::string json =
        R"({"format":1,"network":"rt60_estimator","sample_rate_hz":16000,"channels":)" + channels +
        R"(,"input_rms":)" + rms + "}";
    return refusal([&] { (void)rt60_description_from_json(json, "x"); });
  };
  EXPECT_EQ(said("16", "0.1"), "accepted");
  EXPECT_NE(said("0", "0.1").find("channels: expected 1 to 1024, found 0"), std::string::npos);
  EXPECT_NE(said("16", "-1").find("input_rms"), std::string::npos);
  EXPECT_NE(said("16", "true").find("input_rms"), std::string::npos);
}

TEST(Rt60Description, TensorsHaveTheReleasedShapes) {
  const auto shapes = required_tensors(Rt60Description{});
  using Shape = std::vector<std::int64_t>;
  EXPECT_EQ(shapes.at("feature_extraction.0.weight"), (Shape{64, 1, 7, 7}));
  EXPECT_EQ(shapes.at("feature_extraction.7.1.conv2.weight"), (Shape{512, 512, 3, 3}));
  EXPECT_EQ(shapes.at("predictor.0.weight"), (Shape{1, 512}));
  EXPECT_EQ(required_tensors(Rt60Description{16, {}}).at("predictor.0.weight"), (Shape{1, 128}));
}

TEST(Rt60Weights, WeightFileReadsBack) {
  Rt60EstimatorWeights weights{{1, 0.1}, {}, {}};
  for (const auto& [name, shape] : required_tensors(weights.description)) {
    const std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()), 0.5F);
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  const SafetensorsFile file = to_weight_file(weights, {{"note", "of a test"}});
  EXPECT_EQ(network_kind(file, "x"), NetworkKind::rt60_estimator);
  EXPECT_EQ(file.metadata.at("note"), "of a test");
  const Rt60EstimatorWeights read = rt60_estimator_weights(file, "x");
  EXPECT_EQ(read.description.channels, 1);
  EXPECT_EQ(read.tensors, weights.tensors);
}

}  // namespace
}  // namespace earpoint

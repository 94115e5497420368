#include <functional>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/network_testing/refusal.h>

namespace earpoint {
namespace {

/// The message after replacing `from` by `to` in the JSON of the default network.
std::string refusal_with(const std::string& from, const std::string& to) {
  std::string json = to_json(GtfDescription{});
  const std::size_t at = json.find(from);
  EXPECT_NE(at, std::string::npos) << from << " in " << json;
  json.replace(at, from.size(), to);
  return refusal([&] { (void)gtf_description_from_json(json, "x"); });
}

GtfDescription small() {
  GtfDescription d;
  d.channels = 8;
  d.layers = 2;
  d.bands = 10;
  d.picture_px = 32;
  d.picture_width = d.locator_width = d.summary_width = d.conditioning_width = 6;
  return d;
}

GtfWeights halves(const GtfDescription& d) {
  GtfWeights weights{d, {}, {}};
  for (const auto& [name, shape] : required_tensors(d)) {
    const std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()), 0.5F);
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  return weights;
}

TEST(GtfDescription, JsonRoundTrips) {
  GtfDescription d = small();
  d.tails_s = {0.1, 0.2, 0.4};
  d.highpass_cutoff_hz = 80;
  d.box = d.delays = d.geometry = false;
  d.phase_rounds = 3;
  d.sight_points = 4;
  d.texture = d.dry_voice = true;
  EXPECT_EQ(gtf_description_from_json(to_json(d), "x"), d);
  d.geometry = d.delays = d.ear_delays = d.expected_level = true;
  EXPECT_EQ(gtf_description_from_json(to_json(d), "x"), d);
  EXPECT_EQ(gtf_description_from_json(to_json(GtfDescription{}), "x"), GtfDescription{});
}

TEST(GtfDescription, WhatTheFirstNetworksDidNotHaveIsLeftOutOfTheirFiles) {
  const std::string json = to_json(GtfDescription{});
  for (const char* key :
       {"ear_delays", "expected_level", "phase_rounds", "sight_points", "texture", "dry_voice"}) {
    EXPECT_EQ(json.find(key), std::string::npos) << key;
  }
}

TEST(GtfDescription, JsonMistakesAreNamed) {
  const auto expect = [](const std::string& message, const char* part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.rfind("x: ", 0), 0U) << message;
  };
  expect(refusal_with("\"format\":1", "\"format\":2"), "format: expected 1, found 2");
  expect(refusal_with("\"gtf\"", "\"vigas\""), "expected 'gtf', found 'vigas'");
  expect(refusal_with("\"box\":true,", ""), "the field 'box' is missing");
  expect(refusal_with("\"layers\":6", "\"layers\":6,\"layer\":6"), "unknown key 'layer'");
  expect(refusal_with("\"layers\":6", "\"layers\":0"), "layers: expected 1 to 64, found 0");
  expect(refusal_with("\"bands\":40", "\"bands\":200"), "bands: too many for 257 bins");
  expect(refusal_with("\"picture_px\":64", "\"picture_px\":60"), "a multiple of 32, found 60");
  expect(refusal_with("\"geometry\":true", "\"geometry\":false"), "delays: expected false");
  expect(refusal_with("\"delays\":true", "\"delays\":false,\"ear_delays\":true"),
         "ear_delays: expected false");
  GtfDescription blind;
  blind.geometry = blind.delays = false;
  blind.expected_level = true;
  expect(refusal([&] { check_description(blind, "x"); }), "expected_level: expected false");
  expect(refusal_with("[0.08,0.25]", "[0.08,\"0.25\"]"), "'tails_s': expected numbers");
  expect(refusal_with("\"layers\":6", "\"layers\":6,\"phase_rounds\":17"),
         "phase_rounds: expected 0 to 16, found 17");
  expect(refusal_with("\"picture_px\":64", "\"picture_px\":0,\"sight_points\":2"),
         "sight_points: expected 0, found 2");
  expect(refusal_with("[0.08,0.25]", "[-1]"), "tails_s: expected 0.001 to 10, found -1");
  expect(refusal_with("\"sample_rate_hz\":16000", "\"sample_rate_hz\":48000"),
         "sample_rate_hz: expected 16000, found 48000");
}

TEST(GtfDescription, BandsCoverAllBinsAndGrowWiderAboveTheBend) {
  const std::vector<int> edges = gtf_band_edges(40).value();
  ASSERT_EQ(edges.size(), 41U);
  EXPECT_EQ(edges.front(), 0);
  EXPECT_EQ(edges.back(), GtfDescription::kBins);
  EXPECT_LE(edges[1] - edges[0], 2);
  EXPECT_GE(edges[40] - edges[39], 9);
  EXPECT_EQ(gtf_band_edges(1).value(), (std::vector<int>{0, GtfDescription::kBins}));
}

TEST(GtfDescription, TensorsFollowWhatTheNetworkKnows) {
  GtfDescription d;
  using Shape = std::vector<std::int64_t>;
  EXPECT_EQ(required_tensors(d).at("kernel.weight"), (Shape{4 * 11 * 40, 96}));
  EXPECT_EQ(required_tensors(d).at("picture.output.weight"), (Shape{96, 256}));
  EXPECT_EQ(required_tensors(d).at("locator.0.weight"), (Shape{128, 96 + 9 + 193}));
  EXPECT_EQ(required_tensors(d).at("head.delay_s"), (Shape{72, 2}));
  d.sight_points = 3;
  EXPECT_EQ(required_tensors(d).at("sight.weight"), (Shape{16, 48}));
  EXPECT_EQ(required_tensors(d).at("conditioning.0.weight"),
            (Shape{128, 52 + 96 + 32 + 6 * (16 + 1)}));
  d.sight_points = 0;
  d.delays = d.geometry = false;
  d.picture_px = 0;
  d.tails_s.clear();
  const auto shapes = required_tensors(d);
  EXPECT_FALSE(shapes.contains("dry.weight"));
  EXPECT_FALSE(shapes.contains("head.delay_s") || shapes.contains("locator.0.weight") ||
               shapes.contains("picture.0.weight") || shapes.contains("phase.weight"));
  EXPECT_EQ(shapes.at("conditioning.0.weight"), (Shape{128, 5 + 32}));
  d.texture = d.dry_voice = true;
  EXPECT_EQ(required_tensors(d).at("conditioning.0.weight"), (Shape{128, 5 + 32 + 1}));
  EXPECT_EQ(required_tensors(d).at("dry.weight"), (Shape{257, 96}));
  EXPECT_EQ(shapes.at("kernel.static.weight"), (Shape{4 * 9 * 40, 128}));
}

TEST(GtfWeights, WeightFileReadsBack) {
  const GtfWeights weights = halves(small());
  const SafetensorsFile file = to_weight_file(weights, {{"note", "of a test"}});
  EXPECT_EQ(network_kind(file, "x"), NetworkKind::gtf);
  EXPECT_EQ(file.metadata.at("note"), "of a test");
  const GtfWeights read = gtf_weights(file, "x");
  EXPECT_EQ(read.description, weights.description);
  EXPECT_EQ(read.tensors, weights.tensors);
}

TEST(GtfWeights, TrainingRangeStandsInTheMetadataAndMayBeMissing) {
  GtfWeights weights = halves(small());
  weights.description.training_range = {.farthest_move_m = 8.0, .level_head_deg = 40.0};
  SafetensorsFile file = to_weight_file(weights);
  EXPECT_EQ(gtf_weights(file, "x").description, weights.description);
  file.metadata.erase(std::string(kTrainingRangeKey));
  EXPECT_EQ(gtf_weights(file, "x").description.training_range, GtfTrainingRange{});
  const auto refusal_of = [&](const std::string& range) {
    file.metadata[std::string(kTrainingRangeKey)] = range;
    return refusal([&] { (void)gtf_weights(file, "x"); });
  };
  EXPECT_EQ(refusal_of(R"({"farthest_move_m": 0})"),
            "x: metadata 'earpoint.training_range': 'farthest_move_m': expected more than 0 and at "
            "most 1000, found 0");
  EXPECT_NE(refusal_of(R"({"nearest_m": 1})").find("unknown key 'nearest_m'"), std::string::npos);
}

TEST(GtfWeights, WrongTensorsAreRefused) {
  const auto refusal_of = [](const std::function<void(SafetensorsFile&)>& spoil) {
    SafetensorsFile file = to_weight_file(halves(small()));
    spoil(file);
    return refusal([&] { (void)gtf_weights(file, "x"); });
  };
  EXPECT_EQ(refusal_of([](SafetensorsFile& f) { f.tensors.erase("kernel.bias"); }),
            "x: has no tensor 'kernel.bias' of shape [440]");
  EXPECT_NE(refusal_of([](SafetensorsFile& f) {
              f.tensors["trunk.1.weight"] = f.tensors["trunk.input.weight"];
            }).find("tensor 'trunk.1.weight': expected F32 [8, 8, 3], found F32 [8, 40]"),
            std::string::npos);
}

}  // namespace
}  // namespace earpoint

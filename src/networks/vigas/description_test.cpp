#include <string>

#include <gtest/gtest.h>

#include <earpoint/network/pose_encoding.h>
#include <earpoint/network_testing/refusal.h>
#include <earpoint/vigas/description.h>

namespace earpoint {
namespace {

/// The released SoundSpaces network.
ViGasDescription released() {
  ViGasDescription d;
  d.highpass_cutoff_hz = 80;
  d.image_encoder = ImageEncoderDescription{256, 256, 8};
  d.inputs = {{"visual_feat", 512}, {"tgt_pose", 3}, {"tgt_rotation", 2}, {"bboxes", 4}};
  return d;
}

/// The message after replacing `from` by `to` in the JSON of the released network.
std::string refusal_with(const std::string& from, const std::string& to) {
  std::string json = to_json(released());
  const std::size_t at = json.find(from);
  EXPECT_NE(at, std::string::npos) << from << " in " << json;
  json.replace(at, from.size(), to);
  return refusal([&] { (void)vigas_description_from_json(json, "x"); });
}

TEST(ViGasDescription, JsonRoundTrips) {
  ViGasDescription d = released();
  const std::string json = to_json(d);
  EXPECT_EQ(to_json(vigas_description_from_json(json, "x")), json);

  d.image_encoder->trunk_channels = 16;
  EXPECT_EQ(vigas_description_from_json(to_json(d), "x").image_encoder->trunk_channels, 16);

  d.pose_encoding = PoseEncoding::full;
  d.box_encoding = BoxEncoding::corners;
  d.image_encoder.reset();
  d.highpass_cutoff_hz.reset();
  d.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}};
  d.acausal = false;
  d.kernel_size = d.dilation_base = 2;
  const ViGasDescription read = vigas_description_from_json(to_json(d), "x");
  EXPECT_EQ(to_json(read), to_json(d));
  EXPECT_EQ(read.pose_encoding, PoseEncoding::full);
  EXPECT_FALSE(read.image_encoder);
  EXPECT_FALSE(read.highpass_cutoff_hz);
}

TEST(ViGasDescription, TrunkIsThePublishedOneWhereNothingIsSaid) {
  std::string json = to_json(released());
  const std::string said = ",\"trunk_channels\":64";
  ASSERT_NE(json.find(said), std::string::npos) << json;
  json.erase(json.find(said), said.size());
  EXPECT_EQ(vigas_description_from_json(json, "x").image_encoder->trunk_channels, 64);
}

TEST(ViGasDescription, NarrowTrunksNarrowItsTensors) {
  ViGasDescription d = released();
  d.image_encoder->trunk_channels = 16;
  const auto tensors = required_tensors(d);
  EXPECT_EQ(tensors.at("visual_encoder.0.weight"), (std::vector<std::int64_t>{16, 3, 7, 7}));
  EXPECT_EQ(tensors.at("conv1x1.0.weight"), (std::vector<std::int64_t>{8, 128, 1, 1}));
}

TEST(ViGasDescription, ReleasedNetworksHaveTheWidthsOfThePaper) {
  EXPECT_EQ(released().input_width(), 521);
  EXPECT_EQ(released().layers(), 30);
  EXPECT_EQ(released().dilation(0), 1);
  EXPECT_EQ(released().dilation(29), 19683);
  EXPECT_EQ(released().dilation(10), 1);
  EXPECT_THROW((void)released().dilation(30), std::logic_error);
  EXPECT_EQ((ImageEncoderDescription{384, 216, 8}.feature_width()), 672);
}

TEST(ViGasDescription, JsonMistakesAreNamed) {
  const auto expect = [](const std::string& message, const char* part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.rfind("x: ", 0), 0U) << message;
  };
  expect(refusal_with("\"format\":1", "\"format\":2"), "'format': expected 1, found 2");
  expect(refusal_with("\"vigas\"", "\"sigvas\""), "expected 'vigas', found 'sigvas'");
  expect(refusal_with("\"acausal\":true,", ""), "the field 'acausal' is missing");
  expect(refusal_with("\"acausal\":true", "\"acausal\":1"), "expected true or false, found 1");
  expect(refusal_with("\"blocks\":3", "\"blocks\":3,\"block\":3"), "unknown key 'block'");
  expect(refusal_with("\"blocks\":3", "\"blocks\":3,\"blocks\":3"), "'blocks' occurs twice");
  expect(refusal_with("\"blocks\":3", "\"blocks\":3.5"), "expected a whole number, found 3.5");
  expect(refusal_with("\"blocks\":3", "\"blocks\":18446744073709551615"),
         "expected a whole number");
  expect(refusal_with("\"blocks\":3", "\"blocks\":3000"), "blocks: expected 1 to 1024");
  expect(refusal_with("\"pose_encoding\":\"soundspaces\"", "\"pose_encoding\":\"half\""),
         "expected 'soundspaces' or 'replay' or 'full', found 'half'");
  expect(refusal_with("\"resnet18\"", "\"resnet50\""), "expected 'resnet18', found 'resnet50'");
  expect(refusal_with("\"width_px\":256", "\"width_px\":320"), "'visual_feat' of width 640 first");
  expect(refusal_with("\"tgt_pose\"", "\"bboxes\""), "width of 'bboxes': expected 4, found 3");
  expect(refusal_with("\"tgt_rotation\"", "\"tgt_pose\""), "'tgt_pose' is unknown, repeated");
  expect(refusal_with("\"width\":2", "\"width\":6"),
         "width of 'tgt_rotation': expected 2, found 6");
  expect(refusal_with("\"kernel_size\":3", "\"kernel_size\":4"), "expected an odd number");
  expect(refusal_with("\"dilation_base\":3", "\"dilation_base\":60"), "reach of the last layer");
  expect(refusal_with("\"highpass_cutoff_hz\":80.0", "\"highpass_cutoff_hz\":8000"),
         "less than half of the sample rate");
  expect(refusal_with("{", "{{"), "is not valid JSON at byte");
  expect(refusal([] { (void)vigas_description_from_json(std::string(100000, '['), "x"); }),
         "nested too deeply");
  expect(refusal([] { (void)vigas_description_from_json("[]", "x"); }), "expected an object");
  expect(refusal([] { (void)vigas_description_from_json("{\"format\":1e999}", "x"); }),
         "too large");
}

TEST(ViGasDescription, RequiredTensorsFollowTheDimensions) {
  ViGasDescription d = released();
  auto shapes = required_tensors(d);
  // Trunk: 20 convolutions and as many batch norms of 4; 1x1: 2 + 4; fusion 4; input 2;
  // 30 layers of 12 but one without residual; head 4.
  EXPECT_EQ(shapes.size(), 20U * 5 + 6 + 4 + 2 + 30U * 12 - 2 + 4);
  EXPECT_EQ(shapes.at("fusion.0.weight"), (std::vector<std::int64_t>{512, 521}));
  EXPECT_TRUE(shapes.contains("output_net.29.second.bias"));
  EXPECT_FALSE(shapes.contains("output_net.28.second.bias"));
  EXPECT_TRUE(shapes.contains("hyperconv_wavenet.layers.28.residual.weight"));
  EXPECT_FALSE(shapes.contains("hyperconv_wavenet.layers.29.residual.weight"));
  EXPECT_EQ(shapes.at("visual_encoder.6.0.downsample.0.weight"),
            (std::vector<std::int64_t>{256, 128, 1, 1}));

  d.image_encoder.reset();
  d.channels = 8;
  d.kernel_size = 5;
  shapes = required_tensors(d);
  EXPECT_FALSE(shapes.contains("conv1x1.0.weight"));
  EXPECT_EQ(shapes.at("hyperconv_wavenet.layers.3.conv.w_g.weight"),
            (std::vector<std::int64_t>{8, 8, 5}));
}

TEST(ViGasDescription, EveryOptionThatChangesTheNetworkIsRefused) {
  Checkpoint checkpoint;
  checkpoint.hparams["use_depth"] = true;
  EXPECT_EQ(refusal([&] { (void)describe_vigas(checkpoint, "x"); }),
            "x: hparams: 'use_depth': expected false, found true");
  checkpoint.hparams = {{"model", std::string("wavenet")}};
  EXPECT_EQ(refusal([&] { (void)describe_vigas(checkpoint, "x"); }),
            "x: hparams: 'model': expected 'vigas', found 'wavenet'");
  checkpoint.hparams.clear();
  EXPECT_EQ(refusal([&] { (void)describe_vigas(checkpoint, "x"); }),
            "x: hparams: 'dataset': is missing");
  checkpoint.hparams["dataset"] = std::int64_t{3};
  EXPECT_EQ(refusal([&] { (void)describe_vigas(checkpoint, "x"); }),
            "x: hparams: 'dataset': is of another type than expected: 3");
}

}  // namespace
}  // namespace earpoint

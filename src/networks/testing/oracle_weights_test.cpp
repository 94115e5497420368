#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/network/network_kind.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/network_testing/oracle_weights.h>
#include <earpoint/network_testing/refusal.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

const fs::path kReleased = EARPOINT_SOURCE_DIR "/src/networks/vigas/testdata";
const fs::path kMini = kReleased / "C_mini_noresnet/manifest.json";

TEST(OracleWeights, FollowTheFormula) {
  // By hand: FNV-1a of the empty text is its offset basis, and seed 0 leaves the key alone, so that
  // element 0 is the splitmix64 finaliser of 0xCBF29CE484222325 + 0x9E3779B97F4A7C15, which is
  // 0xC3817C016BA4FF30; its upper 53 bits are 0.76369452509... of 1.
  const OracleRandom random("", 0);
  EXPECT_EQ(random.value(0, 0, 1), 0.7636945250957473F);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const float value = random.value(i, -2, 3);
    EXPECT_GE(value, -2.0F);
    EXPECT_LE(value, 3.0F);
  }
}

TEST(OracleWeights, AreOfTheNetworkThatTheManifestNames) {
  const ViGasWeights weights = make_oracle_vigas(kMini);
  const ViGasDescription& d = weights.description;
  EXPECT_EQ(d.pose_encoding, PoseEncoding::soundspaces);
  EXPECT_EQ(d.channels, 8);
  EXPECT_EQ(d.conditioning_width, 16);
  EXPECT_EQ(d.fusion_width, 24);
  EXPECT_EQ(d.layers(), 4);
  EXPECT_EQ(d.dilation(3), 27);
  EXPECT_TRUE(d.acausal);
  EXPECT_FALSE(d.image_encoder);
  EXPECT_EQ(d.inputs.at(0).name, "visual_feat");
  EXPECT_EQ(d.inputs.at(0).width, 512);
  EXPECT_EQ(d.highpass_cutoff_hz, 80);
  EXPECT_TRUE(weights.unused.empty());
  EXPECT_EQ(weights.at("fusion.0.weight").shape, (std::vector<std::int64_t>{24, 521}));
  EXPECT_THROW((void)weights.at("output_net.0.first.weight"), std::logic_error);
}

TEST(OracleWeights, EqualTheReleasedFormatsCheckpointsBitForBit) {
  std::vector<fs::path> folders{kMini.parent_path()};
  // Also networks of the published size, where available.
  if (const char* whole = std::getenv("EARPOINT_ORACLE_DIR")) {
    folders.push_back(fs::path(whole) / "C_tiny_noresnet");
    folders.push_back(fs::path(whole) / "A_soundspaces");
  }
  for (const fs::path& folder : folders) {
    const Checkpoint made = make_oracle_checkpoint(folder / "manifest.json");
    const Checkpoint read = import_checkpoint(folder / "best_val.ckpt");
    EXPECT_FALSE(made.state_dict.empty());
    EXPECT_EQ(made.state_dict, read.state_dict) << folder;
    EXPECT_EQ(made.hparams, read.hparams) << folder;
  }
}

TEST(OracleWeights, FullNetworksAreDescribedFromTheirTensors) {
  const ViGasDescription a =
      make_oracle_vigas(kReleased / "A_soundspaces/manifest.json").description;
  EXPECT_EQ(a.input_width(), 521);
  EXPECT_EQ(a.layers(), 30);
  EXPECT_EQ(a.image_encoder.value().width_px, 256);
  const ViGasDescription b = make_oracle_vigas(kReleased / "B_replay/manifest.json").description;
  EXPECT_EQ(b.pose_encoding, PoseEncoding::replay);
  EXPECT_EQ(b.box_encoding, BoxEncoding::corners);
  EXPECT_EQ(b.input_width(), 685);
  EXPECT_EQ(b.image_encoder.value().height_px, 216);
  EXPECT_EQ(b.highpass_cutoff_hz, 150);
}

TEST(OracleWeights, TheEstimatorOfReverberationTimeIsRecognised) {
  const SafetensorsFile file = weight_file_from_checkpoint(
      make_oracle_checkpoint(EARPOINT_SOURCE_DIR "/src/networks/rt60/testdata/rt60_weights.json"),
      KeepTensors::required, "x");
  EXPECT_EQ(network_kind(file, "x"), NetworkKind::rt60_estimator);
  EXPECT_EQ(rt60_estimator_weights(file, "x").at("predictor.0.weight").elements(), 512);
  EXPECT_NE(refusal([&] { (void)vigas_weights(file, "x"); }).find("expected 'vigas'"),
            std::string::npos);
}

TEST(Weights, OnlyWhatInferenceReadsIsKeptUnlessAskedFor) {
  const SafetensorsFile small =
      weight_file_from_checkpoint(make_oracle_checkpoint(kMini), KeepTensors::required, "x");
  const SafetensorsFile whole =
      weight_file_from_checkpoint(make_oracle_checkpoint(kMini), KeepTensors::all, "x");
  EXPECT_FALSE(small.tensors.contains("output_net.0.first.weight"));
  EXPECT_TRUE(whole.tensors.contains("output_net.0.first.weight"));
  EXPECT_NE(small.metadata.at("earpoint.dropped_tensors").find("output_net.0.first.weight"),
            std::string::npos);
  EXPECT_FALSE(whole.metadata.contains("earpoint.dropped_tensors"));
  EXPECT_NE(small.metadata.at("earpoint.hparams").find("\"highpass_filter\":true"),
            std::string::npos);
  // Three other heads of four tensors each, and the last layer's residual.
  EXPECT_EQ(vigas_weights(whole, "x").unused.size(), 3U * 4 + 2);
  EXPECT_EQ(vigas_weights(whole, "x").tensors, vigas_weights(small, "x").tensors);
}

TEST(Weights, OptionsThatContradictTheTensorsAreRefused) {
  const auto with = [](const std::string& name, const HyperParameter& value) {
    Checkpoint checkpoint = make_oracle_checkpoint(kMini);
    checkpoint.hparams[name] = value;
    return refusal([&] { (void)describe_vigas(checkpoint, "x"); });
  };
  EXPECT_EQ(with("wavenet_blocks", std::int64_t{1}), "accepted");
  EXPECT_EQ(with("wavenet_blocks", std::int64_t{2}),
            "x: hparams name 2 blocks of 4 layers, but the tensors are of 4 layers");
  EXPECT_EQ(with("layers_per_block", std::int64_t{-4}),
            "x: hparams: 'layers_per_block': is out of range: -4");
  // Without the picture the fusion layer would have 9 columns.
  EXPECT_EQ(with("use_rgb", false),
            "x: tensor 'fusion.0.weight': expected 9 columns for the inputs that hparams name, "
            "found 521");
  EXPECT_EQ(with("base_gain", 1.0), "accepted");
  EXPECT_EQ(with("base_gain", 2.0), "x: hparams: 'base_gain': expected 1, found 2");
}

TEST(Weights, SurviveAFile) {
  const ViGasWeights weights = make_oracle_vigas(kMini);
  const auto bytes = serialize_safetensors(to_weight_file(weights, {{"note", "n"}}), "x");
  const SafetensorsFile file = parse_safetensors(bytes, "x");
  EXPECT_EQ(file.metadata.at("note"), "n");
  EXPECT_EQ(vigas_weights(file, "x").tensors, weights.tensors);
}

TEST(Weights, HalvesAreWidened) {
  SafetensorsFile file = to_weight_file(make_oracle_vigas(kMini));
  Tensor& bias = file.tensors.at("input.bias");
  bias.dtype = DType::f16;
  bias.data.assign(16, std::byte{0x3C});  // 0x3C3C = 1.05859375
  const ViGasWeights weights = vigas_weights(file, "x");
  EXPECT_EQ(weights.at("input.bias").as<float>()[7], 1.05859375F);
}

TEST(Weights, MissingWrongAndUnusableTensorsAreNamed) {
  const SafetensorsFile good = to_weight_file(make_oracle_vigas(kMini));
  const auto with = [&](const std::function<void(SafetensorsFile&)>& change) {
    SafetensorsFile file = good;
    change(file);
    return refusal([&] { (void)vigas_weights(file, "x"); });
  };
  EXPECT_EQ(with([](auto& f) { f.tensors.erase("input.bias"); }),
            "x: has no tensor 'input.bias' of shape [8]");
  EXPECT_EQ(with([](auto& f) {
              f.tensors.at("input.bias").shape = {8, 1};
            }),
            "x: tensor 'input.bias': expected F32 [8], found F32 [8, 1]");
  EXPECT_EQ(with([](auto& f) { f.tensors.at("input.bias").dtype = DType::i32; }),
            "x: tensor 'input.bias': expected F32 [8], found I32 [8]");
  EXPECT_EQ(with([](auto& f) { f.tensors.at("input.bias").data.assign(32, std::byte{0xFF}); }),
            "x: tensor 'input.bias': has NaN or infinite values");
  EXPECT_NE(with([](auto& f) { f.metadata.clear(); }).find("has no metadata 'earpoint.network'"),
            std::string::npos);
}

TEST(Weights, NegativeVariancesAreRefused) {
  SafetensorsFile file =
      to_weight_file(make_oracle_vigas(kReleased / "A_soundspaces/manifest.json"));
  Tensor& variance = file.tensors.at("visual_encoder.1.running_var");
  variance.data[3] |= std::byte{0x80};  // the sign of the first value
  EXPECT_EQ(refusal([&] { (void)vigas_weights(file, "x"); }),
            "x: tensor 'visual_encoder.1.running_var': is a variance but has negative values");
}

}  // namespace
}  // namespace earpoint

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/vigas/checkpoint_export.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/pickle.h>
#include <earpoint/weights/zip_archive.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

fs::path bundled() {
  return fs::path(EARPOINT_SOURCE_DIR) /
         "src/networks/vigas/testdata/C_mini_noresnet/best_val.ckpt";
}

/// Keys of the state dict in the order of the file.
std::vector<std::string> names_in_order(std::span<const std::byte> bytes,
                                        const std::string& folder) {
  const ZipArchive archive(bytes, "checkpoint");
  const std::vector<std::byte> pickled = archive.read(folder + "/data.pkl");
  const Pickle pickle = parse_pickle(pickled, "checkpoint");
  const PickleValue& top = *pickle.top;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < top.items.size(); i += 2) {
    if (top.items[i]->text != "state_dict") continue;
    const auto entries = top.items[i + 1]->entries();
    for (std::size_t k = 0; k < entries.size(); k += 2) names.emplace_back(entries[k]->text);
  }
  return names;
}

std::vector<std::byte> exported(const fs::path& checkpoint, KeepTensors keep,
                                ReleasedCheckpoint& released) {
  released = released_checkpoint(
      weight_file_from_checkpoint(import_checkpoint(checkpoint), keep, "import"), "export");
  return serialize_checkpoint(released, "best_val");
}

/// Import and export preserve a checkpoint of the released code: names and their order, shapes,
/// types, values, and options.
void expect_round_trip(const fs::path& path) {
  ReleasedCheckpoint released;
  const std::vector<std::byte> bytes = exported(path, KeepTensors::all, released);
  EXPECT_TRUE(released.filled.empty());
  const Checkpoint before = import_checkpoint(path);
  const Checkpoint after = parse_checkpoint(bytes, "exported");
  const std::vector<std::string> names = names_in_order(bytes, "best_val");
  EXPECT_EQ(names.size(), before.state_dict.size());
  EXPECT_EQ(names, names_in_order(read_file(path), "best_val"));
  ASSERT_EQ(after.state_dict.size(), before.state_dict.size());
  for (const auto& [name, tensor] : before.state_dict) {
    EXPECT_TRUE(after.state_dict.at(name) == tensor) << name;
  }
  EXPECT_EQ(after.hparams, before.hparams);
}

TEST(CheckpointExport, RoundTripGivesTheReleasedCheckpointBack) {
  expect_round_trip(bundled());
  // Also networks of the published size, where available.
  if (const char* folder = std::getenv("EARPOINT_ORACLE_DIR")) {
    expect_round_trip(fs::path(folder) / "A_soundspaces/best_val.ckpt");
    expect_round_trip(fs::path(folder) / "C_tiny_noresnet/best_val.ckpt");
  }
}

TEST(CheckpointExport, TensorsThatInferenceDoesNotReadAreZero) {
  ReleasedCheckpoint released;
  const std::vector<std::byte> bytes = exported(bundled(), KeepTensors::required, released);
  const Checkpoint before = import_checkpoint(bundled());
  const Checkpoint after = parse_checkpoint(bytes, "exported");
  EXPECT_EQ(released.filled.size(), 14U);
  ASSERT_EQ(after.state_dict.size(), before.state_dict.size());
  const std::set<std::string> filled(released.filled.begin(), released.filled.end());
  for (const auto& [name, tensor] : before.state_dict) {
    const Tensor& found = after.state_dict.at(name);
    EXPECT_EQ(found.shape, tensor.shape) << name;
    if (filled.contains(name)) {
      EXPECT_TRUE(std::ranges::all_of(found.data, [](std::byte b) { return b == std::byte{0}; }));
    } else {
      EXPECT_TRUE(found == tensor) << name;
    }
  }
}

TEST(CheckpointExport, ATrainedNetworkOfThePublishedSizeHasEveryTensorAndOption) {
  // As `earpoint train` writes it: without options of its own.
  ViGasWeights weights;
  weights.description.pose_encoding = PoseEncoding::replay;
  weights.description.box_encoding = BoxEncoding::corners;
  weights.description.highpass_cutoff_hz = 150.0;
  weights.description.image_encoder = ImageEncoderDescription{384, 216, 8};
  weights.description.inputs = {
      {"visual_feat", 672}, {"tgt_pose", 3}, {"tgt_rotation", 6}, {"bboxes", 4}};
  RandomStream random(1);
  weights.tensors = random_tensors(required_tensors(weights.description), random, 0.0, 0.1);
  const ReleasedCheckpoint released = released_checkpoint(to_weight_file(weights), "trained");
  EXPECT_EQ(released.state_dict.size(), 613U);  // of the released Replay network
  EXPECT_EQ(released.hparams.size(), 146U);
  EXPECT_TRUE(released.differences.empty());
  // Read with the options of the released code, it is the same network.
  const Checkpoint read = parse_checkpoint(serialize_checkpoint(released, "x"), "exported");
  EXPECT_EQ(to_json(describe_vigas(read, "exported")), to_json(weights.description));
}

TEST(CheckpointExport, MembersAreStoredAtMultiplesOf64) {
  ReleasedCheckpoint released;
  const std::vector<std::byte> bytes = exported(bundled(), KeepTensors::all, released);
  // Zip: a local header has the lengths of name and extra field at 26 and 28, the size at 22.
  const auto number = [&](std::size_t at, int count) {
    std::size_t value = 0;
    for (int i = count; i-- > 0;) value = value << 8U | std::to_integer<std::size_t>(bytes[at + i]);
    return value;
  };
  std::size_t members = 0;
  for (std::size_t at = 0; number(at, 4) == 0x04034B50; ++members) {
    const std::size_t data = at + 30 + number(at + 26, 2) + number(at + 28, 2);
    EXPECT_EQ(data % 64, 0U);
    at = data + number(at + 22, 4);
  }
  EXPECT_EQ(members, released.state_dict.size() + 2);
}

TEST(CheckpointExport, WhatTheReleasedCodeCannotSayIsRefused) {
  ViGasWeights weights;
  weights.description.pose_encoding = PoseEncoding::full;
  weights.description.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}};
  weights.description.channels = 8;
  weights.description.blocks = 1;
  weights.description.layers_per_block = 2;
  RandomStream random(1);
  weights.tensors = random_tensors(required_tensors(weights.description), random, 0.0, 0.1);
  EXPECT_THROW(static_cast<void>(released_checkpoint(to_weight_file(weights), "own")), InputError);
  weights.description.pose_encoding = PoseEncoding::soundspaces;
  weights.description.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 2}};
  weights.tensors = random_tensors(required_tensors(weights.description), random, 0.0, 0.1);
  const ReleasedCheckpoint small = released_checkpoint(to_weight_file(weights), "own");
  ASSERT_EQ(small.differences.size(), 1U);
  EXPECT_EQ(small.differences[0], "channels: 64 there, 8 here");
}

}  // namespace
}  // namespace earpoint

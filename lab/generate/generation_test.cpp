#include "conversation_folder.h"
#include "dataset_lock.h"

#include <filesystem>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset/soundspaces.h>
#include <earpoint/error.h>
#include <earpoint/generate/generation.h>
#include <earpoint/generate/scene_maker.h>
#include <earpoint/generate_testing/quick_generation.h>
#include <earpoint/scene/material_table.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class GenerationTest : public ::testing::Test {
 protected:
  [[nodiscard]] GenerationSummary generate(const GenerationOptions& options) const {
    SilentProgress silent;
    return generate_dataset(options, TestScenes(), FigureLibrary(), SpeechCorpus::load(corpus_),
                            silent);
  }

  [[nodiscard]] GenerationOptions three_conversations(const char* folder) const {
    GenerationOptions options = quick_options(folder_.path() / folder);
    options.order.conversations = 3;
    return options;
  }

  /// The message with which generate() refuses.
  [[nodiscard]] std::string refusal_of(const GenerationOptions& options) const {
    try {
      static_cast<void>(generate(options));
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }

  TestFolder folder_{"generation_test"};
  fs::path corpus_ = write_test_corpus(folder_.path() / "corpus");
};

TEST_F(GenerationTest, OurReaderMakesSamplesOfEverySplit) {
  const GenerationOptions options = three_conversations("set");
  const GenerationSummary summary = generate(options);
  EXPECT_EQ(summary.conversations, 3);
  EXPECT_EQ(summary.viewpoints, 12);
  EXPECT_EQ(summary.responses, 24);
  EXPECT_EQ(summary.missing, 0);
  for (const std::string split : {"train", "val", "test"}) {
    const SoundSpacesDataset dataset(
        {.root = options.folder, .folder = ".", .split = split, .speech_folder = "speech"});
    ASSERT_EQ(dataset.clips().size(), 1U) << split;
    const SoundSpacesClip& clip = dataset.clips()[0];
    ASSERT_EQ(clip.viewpoints.size(), 4U);
    ASSERT_EQ(clip.speakers.size(), 2U);
    EXPECT_NE(clip.speakers[0].gender, clip.speakers[1].gender);
    for (int target = 1; target < 4; ++target) {
      const NvasSample sample =
          dataset.sample(clip, {.source = 0, .target = target, .speaker = target % 2});
      double energy = 0.0;
      for (const float value : sample.target.planar()) energy += static_cast<double>(value) * value;
      EXPECT_GT(energy, 0.0);
      EXPECT_EQ(sample.target_rgb.width, 256);
    }
  }
}

TEST_F(GenerationTest, TheBytesAreTheSameForAnyJobsAndShards) {
  GenerationOptions whole = three_conversations("whole");
  static_cast<void>(generate(whole));
  const auto expected = contents_of(whole.folder);

  GenerationOptions two_jobs = three_conversations("jobs");
  two_jobs.jobs = 2;
  static_cast<void>(generate(two_jobs));
  EXPECT_EQ(contents_of(two_jobs.folder), expected);

  GenerationOptions shards = three_conversations("shards");
  shards.shard = {.index = 1, .count = 2};
  EXPECT_EQ(generate(shards).missing, 2);
  shards.shard = {.index = 0, .count = 2};
  EXPECT_EQ(generate(shards).missing, 0);
  EXPECT_EQ(contents_of(shards.folder), expected);
}

TEST_F(GenerationTest, ADataSetTellsWhatSetsItsViewpointsApartFromTheUsualOnes) {
  GenerationOptions usual = three_conversations("usual");
  usual.order.conversations = 1;
  static_cast<void>(generate(usual));
  // Older data sets do not have these keys and can be continued.
  EXPECT_EQ(read_text_file(usual.folder / "dataset.json").find("other_rooms"), std::string::npos);
  GenerationOptions varied = usual;
  varied.conversation.other_room_share = 0.5;
  EXPECT_NE(refusal_of(varied).find("other_rooms is missing"), std::string::npos);
  varied.conversation.other_room_share = 0.0;
  varied.conversation.viewpoint_reach_m = 4.0;
  EXPECT_NE(refusal_of(varied).find("viewpoints_reach_m is missing"), std::string::npos);
  varied.conversation.viewpoint_reach_m = ConversationOptions{}.viewpoint_reach_m;
  varied.conversation.height_spread_m = 0.1;
  EXPECT_NE(refusal_of(varied).find("height_spread_m is missing"), std::string::npos);
}

TEST_F(GenerationTest, WhatWasInterruptedGoesOnToTheSameBytes) {
  const GenerationOptions options = three_conversations("set");
  static_cast<void>(generate(options));
  const auto expected = contents_of(options.folder);
  // As a killed process may leave it: one conversation half-written, another not begun, a recording
  // and a scene's metadata missing.
  fs::rename(options.folder / "val/rooms-0/0", options.folder / "val/rooms-0/.0.partial");
  fs::remove(options.folder / "val/rooms-0/.0.partial/report.json");
  fs::remove_all(options.folder / "test");
  fs::remove_all(options.folder / "speech/train-clean-360");
  write_file(options.folder / "speech/.voice.1.partial.flac", "half");
  const GenerationSummary summary = generate(options);
  EXPECT_EQ(summary.simulated, 2);
  EXPECT_EQ(contents_of(options.folder), expected);
}

TEST_F(GenerationTest, WhatLacksAFileIsMadeAgainToTheSameBytes) {
  GenerationOptions options = three_conversations("set");
  options.order.conversations = 1;
  static_cast<void>(generate(options));
  const auto expected = contents_of(options.folder);
  const WorkItem item{.scene = 0, .conversation = 0, .split = "train"};
  ASSERT_TRUE(stored_conversation(options.folder, item, "rooms-0", false));
  EXPECT_FALSE(stored_conversation(options.folder, item, "rooms-0", true));
  for (const char* name : {"rir_2_1.wav", "view_3.png", "clip.json", "report.json"}) {
    const fs::path file = options.folder / "train/rooms-0/0" / name;
    const std::string text = read_text_file(file);
    fs::remove(file);
    EXPECT_FALSE(stored_conversation(options.folder, item, "rooms-0", false)) << name;
    write_file(file, std::string_view());
    EXPECT_FALSE(stored_conversation(options.folder, item, "rooms-0", false)) << name;
    write_file(file, text);
  }
  fs::remove(options.folder / "train/rooms-0/0/rir_0_0.wav");
  EXPECT_EQ(generate(options).simulated, 1);
  EXPECT_EQ(contents_of(options.folder), expected);
}

TEST_F(GenerationTest, TwoProcessesDoNotMakeTheSameConversations) {
  GenerationOptions options = three_conversations("set");
  options.order.conversations = 2;
  DatasetLock other(options.folder, options.order);
  other.take({{.scene = 0, .conversation = 1, .split = "val"}});
  EXPECT_NE(refusal_of(options).find("another process is simulating the same part"),
            std::string::npos)
      << refusal_of(options);
  // Another seed is refused too, although nothing is stored yet.
  GenerationOptions other_seed = options;
  other_seed.seed = 2;
  EXPECT_NE(refusal_of(other_seed).find("seed is 1 there, 2 here"), std::string::npos);
  // A shard without this conversation continues.
  options.shard = {.index = 0, .count = 2};
  EXPECT_EQ(generate(options).simulated, 1);
}

TEST_F(GenerationTest, OtherOptionsInTheSameFolderAreRefused) {
  GenerationOptions options = three_conversations("set");
  options.order.conversations = 1;
  static_cast<void>(generate(options));
  options.seed = 2;
  const std::string refusal = refusal_of(options);
  EXPECT_NE(refusal.find("seed is 1 there, 2 here"), std::string::npos) << refusal;
}

TEST_F(GenerationTest, ARunThatMadeNothingBindsNobody) {
  GenerationOptions options = three_conversations("set");
  options.order.conversations = 1;
  static_cast<void>(generate(options));
  fs::remove_all(options.folder / "train");
  fs::remove_all(options.folder / "speech");
  options.seed = 2;
  EXPECT_EQ(refusal_of(options), "none");
}

TEST(FileSceneMaker, DescriptionTellsHowFilesAreRead) {
  const auto description = [](const ImportOptions& options, const char* materials) {
    return FileSceneMaker({"flat.glb"}, options, materials, [](const auto&, const auto&) {})
        .description();
  };
  EXPECT_EQ(description({}, ""), "files flat.glb, unit 1 m, materials standard");
  EXPECT_EQ(description({.up_axis = UpAxis::z, .unit_m = 0.01, .close_ceiling = true}, ""),
            "files flat.glb, up z, ceiling closed, unit 0.01 m, materials standard");
  const ImportOptions own{.materials = &standard_materials()};
  EXPECT_NE(description(own, "one table"), description(own, "another"));
  EXPECT_EQ(description(own, "one table"), description(own, "one table"));
}

TEST_F(GenerationTest, AnotherSeedMakesOtherConversations) {
  GenerationOptions options = three_conversations("one");
  options.order.conversations = 1;
  static_cast<void>(generate(options));
  GenerationOptions other = options;
  other.folder = folder_.path() / "two";
  other.seed = 2;
  static_cast<void>(generate(other));
  const auto one = contents_of(options.folder);
  const auto two = contents_of(other.folder);
  EXPECT_NE(one.at("train/rooms-0/0/clip.json"), two.at("train/rooms-0/0/clip.json"));
}

TEST_F(GenerationTest, PathsBeginWithThePrefixAndSpeechTakesTheReleasedForm) {
  GenerationOptions options = three_conversations("root/data/synthetic_dataset/v16");
  options.order.conversations = 1;
  options.path_prefix = "data/synthetic_dataset/v16";
  options.speech_form = SpeechForm::released;
  static_cast<void>(generate(options));
  fs::rename(options.folder / "LibriSpeech-wav", folder_.path() / "root/data/LibriSpeech-wav");
  // With the reader's defaults, which are the released loader's.
  const SoundSpacesDataset dataset({.root = folder_.path() / "root", .split = "train"});
  const SoundSpacesClip& clip = dataset.clips().at(0);
  EXPECT_EQ(clip.viewpoints[0].image, "data/synthetic_dataset/v16/train/rooms-0/0/view_0.png");
  const std::string speech = read_text_file(dataset.speech_path(*clip.speakers[0].speech));
  EXPECT_TRUE(speech.starts_with("RIFF"));
  EXPECT_NO_THROW(static_cast<void>(dataset.sample(clip, {.source = 0, .target = 1})));
}

}  // namespace
}  // namespace earpoint

#include "run_program.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset_testing/tiny_dataset.h>

namespace {

namespace fs = std::filesystem;

constexpr const char* kTiny = R"({
 "format": "earpoint-train-1",
 "network": {"kind": "vigas", "blocks": 1, "layers_per_block": 2, "channels": 4, "fusion_width": 8,
             "conditioning_width": 8, "picture": {"width_px": 32, "height_px": 32, "channels": 2}},
 "data": {"window_samples": 4000, "validation_pairs": 2},
 "training": {"batch": 2, "steps": 2, "validate_every": 1}
})";

class TrainCommandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("train_command." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    earpoint::write_tiny_dataset(folder_ / "data", {.clips = 1});
    earpoint::write_file(folder_ / "tiny.json", std::string_view(kTiny));
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] ProgramOutcome train(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {
        "train", (folder_ / "tiny.json").string(), "--data", (folder_ / "data").string(),
        "--out", (folder_ / "run").string(),       "--jobs", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return run_earpoint(words);
  }

  fs::path folder_;
};

TEST_F(TrainCommandTest, WhatWasTrainedRendersAtOnce) {
  const ProgramOutcome trained = train({"--json", "--quiet"});
  ASSERT_EQ(trained.exit_code, 0) << trained.errors;
  EXPECT_TRUE(trained.errors.empty()) << trained.errors;
  const auto summary = nlohmann::json::parse(trained.output);
  EXPECT_EQ(summary.at("steps"), 2);
  EXPECT_EQ(summary.at("clips"), 4);
  EXPECT_EQ(summary.at("metric"), "mag");
  EXPECT_EQ(summary.at("ended_by"), "steps");

  const fs::path heard = folder_ / "heard.wav";
  earpoint::write_sound(heard, [] {
    earpoint::Waveform sound(2, 20000, 16000);
    for (std::size_t i = 0; i < sound.planar().size(); ++i) {
      sound.planar()[i] = 0.1F * static_cast<float>(i % 50) / 50.0F;
    }
    return sound;
  }());
  const ProgramOutcome rendered = run_earpoint(
      {"render", (folder_ / "data/test/room/0/view_1.png").string(), heard.string(), "--model",
       (folder_ / "run/best.safetensors").string(), "--speaker-box", "0.2,0.2,0.4,0.8",
       "--translate", "1,0,0", "-o", (folder_ / "there.wav").string(), "--quiet"});
  ASSERT_EQ(rendered.exit_code, 0) << rendered.errors;
  EXPECT_EQ(earpoint::probe_sound(folder_ / "there.wav").frames, 20000);
}

TEST_F(TrainCommandTest, ARunIsNotOverwrittenAndGoesOnByResume) {
  ASSERT_EQ(train({"--quiet"}).exit_code, 0);
  const ProgramOutcome again = train({"--quiet"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.errors.find("holds a run already; go on with it by --resume"), std::string::npos)
      << again.errors;
  std::string longer = kTiny;
  longer.replace(longer.find("\"steps\": 2"), 10, "\"steps\": 3");
  earpoint::write_file(folder_ / "tiny.json", longer);
  const ProgramOutcome resumed = train({"--resume", "--quiet", "--json"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_EQ(nlohmann::json::parse(resumed.output).at("steps"), 3);
}

TEST_F(TrainCommandTest, BadUseIsOneLine) {
  const auto error_of = [&](const std::vector<std::string>& more) {
    const ProgramOutcome outcome = train(more);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
    return outcome.errors;
  };
  EXPECT_NE(error_of({"--device", "quantum"}).find("--device quantum"), std::string::npos);
  EXPECT_NE(error_of({"--minutes", "0"}).find("--minutes: expected more than 0"),
            std::string::npos);
  std::string misspelt = kTiny;
  misspelt.replace(misspelt.find("\"batch\""), 7, "\"bathc\"");
  earpoint::write_file(folder_ / "tiny.json", misspelt);
  EXPECT_NE(error_of({}).find("tiny.json: 'training': unknown key 'bathc'"), std::string::npos)
      << error_of({});
}

TEST_F(TrainCommandTest, BadFilesEndItByNameOrAreSkipped) {
  earpoint::write_file(folder_ / "data/train/room/0/view_1.png", std::string_view("no picture"));
  const ProgramOutcome ended = train({"--quiet"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_NE(ended.errors.find("view_1.png"), std::string::npos) << ended.errors;
  fs::remove_all(folder_ / "run");
  const ProgramOutcome skipped = train({"--quiet", "--skip-bad"});
  EXPECT_EQ(skipped.exit_code, 0);
  EXPECT_NE(skipped.errors.find("skipped: "), std::string::npos) << skipped.errors;
}

}  // namespace

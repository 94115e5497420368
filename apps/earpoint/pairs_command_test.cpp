#include "run_program.h"

#include <algorithm>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset_testing/tiny_dataset.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// A data set as it is downloaded: the published folders, and no pair list.
class PairsCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / ("pairs_command." + std::to_string(::getpid()));
    fs::remove_all(root_);
    write_published_dataset(root_, {.clips = 2});
  }
  void TearDown() override { fs::remove_all(root_); }

  static std::string refusal(const std::vector<std::string>& words) {
    const ProgramOutcome outcome = run_earpoint(words);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    return outcome.errors;
  }

  fs::path root_;
};

TEST_F(PairsCommand, ADownloadIsEvaluatedFromItsRootOrItsFolderWithoutAList) {
  for (const char* folder : {"", "data/synthetic_dataset/v16"}) {
    const ProgramOutcome outcome = run_earpoint({"evaluate", "--data", (root_ / folder).string(),
                                                 "--methods", "input", "--json", "--quiet"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
    const auto json = nlohmann::json::parse(outcome.output);
    EXPECT_EQ(json.at("clips"), 6);
    EXPECT_EQ(json.at("voices"), 2);
    EXPECT_NE(json.at("pairs").get<std::string>().find("drawn"), std::string::npos);
  }
}

TEST_F(PairsCommand, WritesTheListThatEvaluateTakes) {
  const ProgramOutcome written = run_earpoint({"pairs", "--data", root_.string()});
  ASSERT_EQ(written.exit_code, 0) << written.errors;
  EXPECT_NE(written.output.find("6 pairs of 2 clips"), std::string::npos) << written.output;
  const ProgramOutcome outcome = run_earpoint(
      {"evaluate", "--data", root_.string(), "--methods", "input", "--json", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(nlohmann::json::parse(outcome.output).at("pairs"),
            (root_ / "pairs-test.json").string());
  EXPECT_NE(refusal({"pairs", "--data", root_.string()}).find("exists already"), std::string::npos);

  const std::string released = (root_ / "released.json").string();
  ASSERT_EQ(run_earpoint({"pairs", "--data", root_.string(), "--draw", "released", "-o", released})
                .exit_code,
            0);
  const auto list = nlohmann::json::parse(read_text_file(released));
  ASSERT_EQ(list.at("pairs").size(), 2U);
  for (const auto& pair : list.at("pairs")) EXPECT_EQ(pair.at("window_start"), 0);
  const auto mag = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"evaluate", "--data", root_.string(), "--methods",
                                   "input",    "--json", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramOutcome measured = run_earpoint(words);
    EXPECT_EQ(measured.exit_code, 0) << measured.errors;
    return nlohmann::json::parse(measured.output).at("rows")[0].at("mag").at("mean").get<double>();
  };
  EXPECT_EQ(mag({"--pairs", released}), mag({"--draw", "released"}));
  EXPECT_NE(mag({"--draw", "released"}), mag({}));
}

TEST_F(PairsCommand, BothDataSetsUnderOneRootAskForTheLayout) {
  fs::create_directories(root_ / "data/appen_dataset/v3");
  write_file(root_ / "data/appen_dataset/v3/metadata_v2.json", std::string_view("{}"));
  const std::string data = root_.string();
  EXPECT_NE(refusal({"evaluate", "--data", data, "--quiet"})
                .find("choose the layout, soundspaces or replay (--layout)"),
            std::string::npos);
  EXPECT_EQ(run_earpoint({"evaluate", "--data", data, "--layout", "soundspaces", "--methods",
                          "input", "--quiet"})
                .exit_code,
            0);
  EXPECT_NE(refusal({"evaluate", "--data", data, "--layout", "replay", "--pairs",
                     (root_ / "none.json").string(), "--quiet"})
                .find("Replay-NVAS has no pair lists"),
            std::string::npos);
  EXPECT_NE(refusal({"evaluate", "--data", data, "--layout", "v16"}).find("--layout"),
            std::string::npos);
  EXPECT_NE(refusal({"pairs", "--data", (root_ / "data/appen_dataset").string()})
                .find("holds neither a dataset.json nor data/synthetic_dataset/v16"),
            std::string::npos);
}

TEST_F(PairsCommand, SixteenBitSpeechIsNotTakenInSilence) {
  write_published_dataset(root_, {.clips = 1}, true);
  const ProgramOutcome outcome = run_earpoint(
      {"evaluate", "--data", root_.string(), "--methods", "input", "--json", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("16-bit speech"), std::string::npos) << outcome.errors;
}

}  // namespace

}  // namespace earpoint

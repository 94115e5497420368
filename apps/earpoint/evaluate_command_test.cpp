#include "run_program.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>

namespace {

namespace fs = std::filesystem;

/// A home with three conversations of two voices, simulated once for all tests.
class EvaluateCommandTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::path(testing::TempDir()) / ("evaluate_command." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "speech");
    // Stand-ins for furniture and people, so that the test is the same everywhere.
    ::setenv("EARPOINT_DATA_DIR", (folder_ / "nothing").c_str(), 1);
    std::string index = "file,speaker,gender,split\n";
    for (const std::string gender : {"female", "male"}) {
      earpoint::Waveform sound(1, 20000, 16000);
      earpoint::RandomStream random(gender.size());
      for (float& sample : sound.channel(0)) sample = static_cast<float>(random.uniform(-0.1, 0.1));
      earpoint::write_sound(folder_ / "speech" / (gender + ".wav"), sound);
      index += gender + ".wav," + gender + " voice," + gender + ",test\n";
    }
    earpoint::write_file(folder_ / "speech" / "speech.csv", index);
    const ProgramOutcome outcome = run_earpoint(
        {"simulate", "--scenes", "1", "--conversations", "3", "--split", "test", "--speech",
         (folder_ / "speech").string(), "--out", (folder_ / "data").string(), "--rays", "50",
         "--duration", "0.3", "--jobs", "1", "--quiet"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  }
  static void TearDownTestSuite() {
    ::unsetenv("EARPOINT_DATA_DIR");
    fs::remove_all(folder_);
  }

  static ProgramOutcome evaluate(const fs::path& data, const std::vector<std::string>& more) {
    std::vector<std::string> words{"evaluate", "--data", data.string(), "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return run_earpoint(words);
  }

  /// A copy of the data set to break.
  static fs::path copy_of_data(const std::string& name) {
    fs::copy(folder_ / "data", folder_ / name, fs::copy_options::recursive);
    return folder_ / name;
  }

  inline static fs::path folder_;
};

TEST_F(EvaluateCommandTest, JsonHasARowPerMethodWithIntervals) {
  const ProgramOutcome outcome = evaluate(folder_ / "data", {"--methods", "input,dsp", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("clips"), 12);
  EXPECT_EQ(json.at("conversations"), 3);
  ASSERT_EQ(json.at("rows").size(), 2U);
  EXPECT_EQ(json.at("rows")[0].at("method"), "input");
  EXPECT_EQ(json.at("rows")[1].at("method"), "dsp");
  for (const auto& row : json.at("rows")) {
    for (const char* key : {"mag", "lre_db", "level_db", "itd_us", "l2", "stft_distance"}) {
      const auto& cell = row.at(key);
      EXPECT_GT(cell.at("mean"), 0.0) << key;
      EXPECT_LE(cell.at("low"), cell.at("mean")) << key;
      EXPECT_GE(cell.at("high"), cell.at("mean")) << key;
      EXPECT_GT(row.at("released").at(key).at("mean"), 0.0) << key;
    }
  }
  EXPECT_EQ(json.at("rows")[0].at("mag").at("ratio").at("value"), 1.0);
}

TEST_F(EvaluateCommandTest, ThreadsDoNotChangeTheNumbers) {
  const ProgramOutcome two = evaluate(folder_ / "data", {"--json", "--jobs", "2"});
  const ProgramOutcome one = evaluate(folder_ / "data", {"--json", "--jobs", "1"});
  ASSERT_EQ(one.exit_code, 0) << one.errors;
  EXPECT_EQ(one.output, two.output);
}

TEST_F(EvaluateCommandTest, OraclesAreRowsOfTheirOwn) {
  const ProgramOutcome outcome = evaluate(
      folder_ / "data", {"--methods", "input,oracle-gain", "--oracles", "--json", "--limit", "3"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(json.at("rows").size(), 5U);
  EXPECT_EQ(json.at("rows")[4].at("method"), "oracle-all");
  EXPECT_EQ(json.at("rows")[4].at("is_oracle"), true);
  EXPECT_LT(json.at("rows")[4].at("mag").at("mean"), 1e-5);
}

TEST_F(EvaluateCommandTest, TableAndLimitAreForPeople) {
  const ProgramOutcome outcome = evaluate(folder_ / "data", {"--methods", "input", "--limit", "3"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("Mag"), std::string::npos);
  // Spread over the list, one pair of every conversation.
  EXPECT_NE(outcome.output.find("3 clips of 3 conversations"), std::string::npos) << outcome.output;
}

TEST_F(EvaluateCommandTest, BrokenPairsAreNamedAndSkippedOnlyWhenAsked) {
  const fs::path data = copy_of_data("broken");
  const fs::path scene = data / "test/home-0000";
  // What viewpoints of three conversations hear: missing, empty, of a rate too low, not a number.
  // Every viewpoint is the target of one pair.
  for (const std::string speaker : {"0", "1"}) {
    fs::remove(scene / ("0/rir_0_" + speaker + ".wav"));
    earpoint::write_file(scene / ("0/rir_1_" + speaker + ".wav"), std::string_view(""));
    earpoint::write_sound(scene / ("1/rir_0_" + speaker + ".wav"),
                          earpoint::Waveform(2, 100, 8000));
    const fs::path path = scene / ("2/rir_1_" + speaker + ".wav");
    std::string bytes = earpoint::read_text_file(path);
    std::fill(bytes.end() - 8, bytes.end(), '\xFF');  // the last sample of both ears
    earpoint::write_file(path, bytes);
  }
  const ProgramOutcome stopped = evaluate(data, {"--methods", "input"});
  EXPECT_EQ(stopped.exit_code, 2);
  EXPECT_EQ(std::count(stopped.errors.begin(), stopped.errors.end(), '\n'), 1) << stopped.errors;
  EXPECT_NE(stopped.errors.find("home-0000, clip 0"), std::string::npos) << stopped.errors;
  EXPECT_NE(stopped.errors.find("--skip-bad"), std::string::npos) << stopped.errors;

  const ProgramOutcome outcome = evaluate(data, {"--methods", "input", "--skip-bad", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("clips").get<std::size_t>() + json.at("skipped").size(), 12U);
  EXPECT_GE(json.at("clips"), 1);
  const auto is_named = [&](const std::string& file, const std::string& problem) {
    return std::ranges::any_of(json.at("skipped"), [&](const auto& pair) {
      const std::string text = pair.at("problem");
      return text.find(file) != std::string::npos && text.find(problem) != std::string::npos;
    });
  };
  EXPECT_TRUE(is_named("0/rir_0_", "no such file")) << outcome.errors;
  EXPECT_TRUE(is_named("0/rir_1_", "empty")) << outcome.errors;
  EXPECT_TRUE(is_named("1/rir_0_", "8000 Hz")) << outcome.errors;
  EXPECT_TRUE(is_named("2/rir_1_", "finite")) << outcome.errors;
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'),
            std::ssize(json.at("skipped")));
}

TEST_F(EvaluateCommandTest, BadUseIsOneLine) {
  const auto error_of = [&](const std::vector<std::string>& more) {
    const ProgramOutcome outcome = evaluate(folder_ / "data", more);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    return outcome.errors;
  };
  EXPECT_NE(
      error_of({"--methods", "nothing-of-ours"}).find("name a weight file: nothing-of-ours=F"),
      std::string::npos);
  EXPECT_NE(error_of({"--methods", "input,input"}).find("names input twice"), std::string::npos);
  EXPECT_NE(error_of({"--methods", "=x"}).find("expected NAME=FILE"), std::string::npos);
  // This data set has no training split for tf.
  EXPECT_NE(error_of({"--methods", "tf"}).find("train: no such folder"), std::string::npos);
  EXPECT_NE(error_of({"--split", "val"}).find("val: no such folder"), std::string::npos);
  EXPECT_NE(error_of({"--pairs", "none.json"}).find("none.json"), std::string::npos);
}

}  // namespace

#include "run_program.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/record_testing/test_session.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// A session of four cameras and two people, and clips of it.
class RecordCommand : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder() = fs::path(testing::TempDir()) / ("record_command." + std::to_string(::getpid()));
    fs::remove_all(folder());
    TestSession made =
        make_test_session({.cameras = 4, .people = 2, .duration_s = 24.0, .reverberation_s = 0.0});
    write_test_session(folder(), made);
  }
  static void TearDownTestSuite() { fs::remove_all(folder()); }

  static fs::path& folder() {
    static fs::path path;
    return path;
  }
  static std::string in(const char* name) { return (folder() / name).string(); }
};

TEST_F(RecordCommand, SyncTellsHowFarClocksAreFromTheTruth) {
  const ProgramOutcome outcome =
      run_earpoint({"record", "sync", in("session.json"), "--truth", in("truth.json"), "--json",
                    "--plot", in("sync.png"), "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  // The required accuracy. The movies' AAC adds noise of its own.
  EXPECT_LE(json.at("offset_error_ms_p95").get<double>(), 0.5);
  // 0.3 ms over 24 s.
  EXPECT_LE(json.at("drift_error_ppm_p95").get<double>(), 12.5);
  EXPECT_EQ(json.at("devices").size(), 6U);
  EXPECT_GT(fs::file_size(folder() / "sync.png"), 1000U);
}

TEST_F(RecordCommand, PreparedClipsAreEvaluated) {
  const std::string out = in("prepared");
  for (const char* split : {"train", "test"}) {
    // The same session as two scenes: nothing is trained on it here.
    const fs::path scene = folder() / (std::string("session-") + split + ".json");
    auto json = nlohmann::json::parse(read_text_file(folder() / "session.json"));
    json["scene"] = split;
    write_file(scene, std::string_view(json.dump()));
    const ProgramOutcome made = run_earpoint(
        {"record", "prepare", scene.string(), "--out", out, "--split", split, "--quiet"});
    ASSERT_EQ(made.exit_code, 0) << made.errors;
    EXPECT_NE(made.output.find("clips of 4 cameras"), std::string::npos) << made.output;
  }
  const ProgramOutcome outcome =
      run_earpoint({"evaluate", "--data", out, "--layout", "replay", "--methods", "input,tf,dsp",
                    "--limit", "4", "--json", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("clips"), 4);
  EXPECT_EQ(json.at("rows").size(), 3U);

  const ProgramOutcome enhanced =
      run_earpoint({"evaluate", "--data", out, "--layout", "replay", "--enhance", "--methods",
                    "input,enhance", "--limit", "4", "--json", "--quiet"});
  ASSERT_EQ(enhanced.exit_code, 0) << enhanced.errors;
  const auto speech = nlohmann::json::parse(enhanced.output);
  EXPECT_EQ(speech.at("target"), "near_microphone");
  EXPECT_TRUE(speech.at("ambient_db").is_null());
  // The recordings have noise, but no room.
  const auto& rows = speech.at("rows");
  EXPECT_GT(rows[0].at("estoi").at("mean"), 0.3);
  EXPECT_LT(rows[0].at("mag").at("mean"), 1.0);
  EXPECT_NE(rows[1].at("mag").at("mean"), rows[0].at("mag").at("mean"));
}

TEST_F(RecordCommand, AFieldThatIsWrongIsNamedInALine) {
  write_file(folder() / "wrong.json",
             std::string_view(R"({"format": "earpoint-session-1", "cameras": 7})"));
  const ProgramOutcome outcome = run_earpoint({"record", "sync", in("wrong.json")});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.errors.find("wrong.json: cameras: expected a list"), std::string::npos)
      << outcome.errors;
}

}  // namespace

}  // namespace earpoint

#include "run_program.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset_testing/tiny_dataset.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class StudyCommandTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("study-command-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    write_tiny_dataset(folder_ / "data", {.clips = 6});
  }
  void TearDown() override { fs::remove_all(folder_); }

  ProgramOutcome make(const std::vector<std::string>& more = {},
                      const std::string& methods = "input,dsp") {
    std::vector<std::string> arguments{
        "study",      "make",  "--data",    (folder_ / "data").string(),
        "--methods",  methods, "--count",   "3",
        "--controls", "1",     "--seconds", "1",
        "-o",         study(), "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_earpoint(arguments);
  }
  [[nodiscard]] std::string study() const { return (folder_ / "study").string(); }

  fs::path folder_;
};

void expect_refused(const ProgramOutcome& outcome, const std::string& part) {
  EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
}

TEST_F(StudyCommandTest, MakesAStudyLetsSimulatedParticipantsInAndReports) {
  const ProgramOutcome made = make({"--webmushra"});
  ASSERT_EQ(made.exit_code, 0) << made.errors;
  EXPECT_TRUE(fs::exists(folder_ / "study" / "webmushra.yaml"));
  for (const char* rule : {"mag", "random"}) {
    const ProgramOutcome simulated =
        run_earpoint({"study", "simulate", study(), "--rule", rule, "--count", "2"});
    ASSERT_EQ(simulated.exit_code, 0) << simulated.errors;
    EXPECT_NE(simulated.output.find("simulated participant 2 of 2"), std::string::npos);
  }
  const ProgramOutcome told = run_earpoint({"study", "report", study(), "--json"});
  ASSERT_EQ(told.exit_code, 0) << told.errors;
  const json report = json::parse(told.output);
  ASSERT_EQ(report["groups"].size(), 2U);
  EXPECT_EQ(report["groups"][0]["name"], "simulated: mag");
  EXPECT_EQ(report["groups"][0]["answers"], 2 * 3);
  const ProgramOutcome page =
      run_earpoint({"study", "report", study(), "-o", (folder_ / "report").string()});
  ASSERT_EQ(page.exit_code, 0) << page.errors;
  EXPECT_NE(page.output.find("NOT PEOPLE"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder_ / "report" / "index.html"));
}

TEST_F(StudyCommandTest, RefusesBadUseInALine) {
  expect_refused(run_earpoint({"study", "serve", study()}), "study.json");
  expect_refused(run_earpoint({"study", "report", study()}), "study.json");
  expect_refused(make({}, "input"), "--methods");
  expect_refused(make({"--design", "magic"}), "--design");
  expect_refused(make({}, "input,oracle-all"), "oracle");
  EXPECT_FALSE(fs::exists(study()));
  ASSERT_EQ(make().exit_code, 0);
  expect_refused(make(), "not empty");
  expect_refused(run_earpoint({"study", "report", study()}), "nobody has taken part");
}

}  // namespace
}  // namespace earpoint

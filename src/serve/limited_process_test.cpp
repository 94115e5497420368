#include <chrono>

#include <gtest/gtest.h>

#include <earpoint/serve/limited_process.h>

namespace earpoint {
namespace {

ProcessEnd shell(const std::string& script, const ProcessLimits& limits = {}) {
  return run_limited("/bin/sh", {"-c", script}, limits);
}

TEST(LimitedProcess, TellsHowItEnded) {
  const ProcessEnd end = shell("echo unheard; echo heard >&2; exit 3");
  EXPECT_EQ(end.exit_code, 3);
  EXPECT_EQ(end.errors, "heard\n");
  EXPECT_FALSE(end.is_out_of_time);
  EXPECT_EQ(shell("kill -SEGV $$").exit_code, -1);
  EXPECT_NE(run_limited("/no/such/program", {}, {}).exit_code, 0);
}

TEST(LimitedProcess, EndsWhatHangsWithAllThatItStarted) {
  const auto began = std::chrono::steady_clock::now();
  // The first keeps standard error open, the second does not: both must be ended.
  for (const char* script : {"sleep 60 & sleep 60", "exec 2>/dev/null; sleep 60"}) {
    const ProcessEnd end = shell(script, {.wall_time = std::chrono::seconds(1)});
    EXPECT_TRUE(end.is_out_of_time) << script;
    EXPECT_NE(end.exit_code, 0) << script;
  }
  // Two seconds of waiting; the rest is a margin for a busy machine.
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(30));
}

TEST(LimitedProcess, EndsWhatTakesTooMuchProcessorTime) {
  EXPECT_TRUE(
      shell("while :; do :; done", {.processor_time = std::chrono::seconds(1)}).is_out_of_time);
}

TEST(LimitedProcess, WritesNoFileBeyondTheLimit) {
  const std::string file = testing::TempDir() + "limited_process";
  const ProcessEnd end = shell("head -c 100000 /dev/zero > '" + file + "'", {.file_bytes = 1000});
  EXPECT_NE(end.exit_code, 0);
}

TEST(LimitedProcess, KeepsTheFirstOfManyErrors) {
  EXPECT_EQ(shell("head -c 100000 /dev/zero >&2").errors.size(), 4096U);
}

}  // namespace
}  // namespace earpoint

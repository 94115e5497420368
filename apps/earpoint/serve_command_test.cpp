#include "run_program.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace earpoint {
namespace {

void expect_refused(const std::vector<std::string>& arguments, const std::string& part) {
  const ProgramOutcome outcome = run_earpoint(arguments);
  EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
  EXPECT_EQ(outcome.output, "");
}

TEST(ServeCommand, RefusesBadInputInALineBeforeItServes) {
  const std::string clip = EARPOINT_SOURCE_DIR "/examples/clip.mp4";
  expect_refused({"serve", "missing.mp4", "--quiet"}, "missing.mp4");
  expect_refused({"serve", EARPOINT_SOURCE_DIR "/README.md", "--quiet"}, "README.md");
  expect_refused({"serve", clip, "--model", "missing.safetensors", "--quiet"},
                 "missing.safetensors");
  expect_refused({"serve", clip, "--speaker", "1e9,0,0", "--quiet"}, "--speaker");
  expect_refused({"serve", clip, "--methods", "input,magic", "--quiet"}, "magic");
  expect_refused({"serve", "--data", "nowhere", "--quiet"}, "nowhere");
  expect_refused({"serve", "--earpoints", "missing.json", "--quiet"}, "missing.json");
  expect_refused({"serve", "--no-uploads"}, "nothing to listen to");
}

}  // namespace
}  // namespace earpoint

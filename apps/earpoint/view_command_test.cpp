#include "run_program.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class ViewCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("view_command_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_ / name).string();
  }

  [[nodiscard]] std::vector<std::string> arguments(std::vector<std::string> more) const {
    std::vector<std::string> all = {
        "view",     "--shoebox",          "6,5,3", "--size",        "48x32",
        "--camera", "0.5,0.5,1.5,yaw=40", "-o",    path("view.png")};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  /// Exit 2, one line on standard error, nothing written.
  /// @return that line
  std::string refusal(const std::vector<std::string>& all) {
    const ProgramOutcome outcome = run_earpoint(all);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_TRUE(fs::is_empty(folder_));
    return outcome.errors;
  }

  fs::path folder_;
};

TEST_F(ViewCommand, WritesPictureDepthAndMask) {
  const ProgramOutcome outcome =
      run_earpoint(arguments({"--depth", path("depth.png"), "--mask", path("mask.png")}));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  for (const char* name : {"view.png", "depth.png", "mask.png"}) {
    const Image picture = read_image(path(name));
    EXPECT_EQ(picture.width(), 48) << name;
    EXPECT_EQ(picture.height(), 32) << name;
    EXPECT_GT(*std::ranges::max_element(picture.pixels()), 60) << name;
  }
}

TEST_F(ViewCommand, GivesTheSameBytesForAnyNumberOfJobs) {
  ASSERT_EQ(run_earpoint(arguments({"--jobs", "1"})).exit_code, 0);
  const auto one = read_file(path("view.png"));
  ASSERT_EQ(run_earpoint(arguments({"--jobs", "3"})).exit_code, 0);
  EXPECT_EQ(read_file(path("view.png")), one);
}

TEST_F(ViewCommand, SeesAModelFromAFile) {
  const ProgramOutcome outcome =
      run_earpoint({"view", EARPOINT_SOURCE_DIR "/lab/scene/testdata/room.glb", "--camera",
                    "1,1,1.2,yaw=30", "--size", "32x32", "-o", path("view.png")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(read_image(path("view.png")).width(), 32);
}

TEST_F(ViewCommand, SeesAHome) {
  const ProgramOutcome outcome = run_earpoint(
      {"view", "--home", "3", "--camera", "2,2,1.5", "--size", "32x32", "-o", path("view.png")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
}

TEST_F(ViewCommand, RefusesInOneLineWhatItCannotDo) {
  EXPECT_NE(refusal(arguments({"--fov", "180"})).find("--fov: expected 1 to 170"),
            std::string::npos);
  EXPECT_NE(refusal(arguments({"--samples", "5"})).find("square number"), std::string::npos);
  EXPECT_NE(refusal(arguments({"--home", "1"})).find("several are given"), std::string::npos);
  EXPECT_NE(refusal(arguments({"--up", "z"})).find("--up: applies only to"), std::string::npos);
  EXPECT_NE(refusal(arguments({"--exposure", "0"})).find("--exposure"), std::string::npos);
  EXPECT_NE(refusal(arguments({"--depth-range", "-1"})).find("--depth-range"), std::string::npos);
  for (const char* size : {"48", "0x32", "48x", "48x32x3", "axb", "9999x2"}) {
    std::vector<std::string> all = arguments({});
    std::replace(all.begin(), all.end(), std::string("48x32"), std::string(size));
    EXPECT_NE(refusal(all).find("--size: expected WIDTHxHEIGHT"), std::string::npos) << size;
  }
  std::vector<std::string> all = arguments({});
  std::replace(all.begin(), all.end(), std::string("0.5,0.5,1.5,yaw=40"), std::string("1,2"));
  EXPECT_NE(refusal(all).find("--camera"), std::string::npos);
  all = arguments({});
  std::replace(all.begin(), all.end(), std::string("6,5,3"), std::string("20000,5,3"));
  EXPECT_NE(refusal(all).find("is 20000 m long"), std::string::npos);
  EXPECT_NE(refusal({"view", "--camera", "1,1,1", "-o", path("view.png")}).find("none is given"),
            std::string::npos);
  EXPECT_NE(refusal({"view", path("missing.glb"), "--camera", "1,1,1", "-o", path("view.png")})
                .find("missing.glb"),
            std::string::npos);
}

}  // namespace

}  // namespace earpoint

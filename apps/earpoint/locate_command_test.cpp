#include "gtf_file.h"
#include "run_program.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/random.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class LocateCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("locate_command_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    Waveform sound(2, 35 * 1600, 16000);
    RandomStream random(5);
    for (float& sample : sound.planar()) sample = static_cast<float>(0.05 * random.normal());
    write_sound(at("sound.wav"), sound, SampleFormat::float32);
    write_image(at("frame.png"), Image(64, 48, 3, 90));
    write_gtf_file(at("gtf.safetensors"));
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string at(const char* name) const { return (folder_ / name).string(); }

  void expect_refused(std::vector<std::string> arguments, const std::string& part) const {
    arguments.insert(arguments.begin(), "locate");
    arguments.push_back("--quiet");
    const ProgramOutcome outcome = run_earpoint(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
    EXPECT_EQ(outcome.output, "");
  }

  fs::path folder_;
};

TEST_F(LocateCommand, SaysDirectionAndIn3dTheRest) {
  const std::vector<std::string> arguments = {
      "locate",        at("frame.png"),   at("sound.wav"), "--model", at("gtf.safetensors"),
      "--speaker-box", "0.1,0.2,0.3,0.9", "--quiet"};
  const ProgramOutcome plain = run_earpoint(arguments);
  ASSERT_EQ(plain.exit_code, 0) << plain.errors;
  EXPECT_EQ(plain.errors, "");
  EXPECT_NE(plain.output.find("degrees"), std::string::npos);
  EXPECT_NE(plain.output.find("sound, picture, box"), std::string::npos) << plain.output;
  EXPECT_EQ(plain.output.find("heading"), std::string::npos);

  std::vector<std::string> all = arguments;
  all.insert(all.end(), {"--3d", "--plot", at("map.png")});
  const ProgramOutcome full = run_earpoint(all);
  ASSERT_EQ(full.exit_code, 0) << full.errors;
  for (const char* word : {"direction", "distance", "position", "heading"}) {
    EXPECT_NE(full.output.find(word), std::string::npos) << word;
  }
  EXPECT_GT(read_image(at("map.png")).width(), 100);
}

TEST_F(LocateCommand, ItsJsonHoldsEveryWindowAndAgreesWithItself) {
  const ProgramOutcome outcome = run_earpoint(
      {"locate", at("sound.wav"), "--model", at("gtf.safetensors"), "--3d", "--json", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json["by"], nlohmann::json::array({"sound"}));
  // 3.5 s: three windows, and a remainder of half a window.
  ASSERT_EQ(json["windows"].size(), 4U);
  EXPECT_EQ(json["windows"][3]["time_s"], 3.5);
  for (const char* key : {"azimuth_deg", "elevation_deg", "distance_m", "position_m", "heading_deg",
                          "heading_certainty", "azimuth_spread_deg", "distance_spread"}) {
    EXPECT_TRUE(json["speaker"].contains(key)) << key;
  }
  const double x = json["speaker"]["position_m"][0];
  const double y = json["speaker"]["position_m"][1];
  // Pi is typed with nine digits.
  EXPECT_NEAR(json["speaker"]["azimuth_deg"].get<double>(), std::atan2(y, x) * 180 / 3.14159265,
              1e-3);
}

TEST_F(LocateCommand, WhatItCannotUseGetsOneLine) {
  expect_refused({at("none.wav"), "--model", at("gtf.safetensors")}, "none.wav");
  expect_refused({at("frame.png"), "--model", at("gtf.safetensors")}, "picture without sound");
  expect_refused({at("sound.wav"), "--model", at("sound.wav")}, "sound.wav");
  expect_refused(
      {at("sound.wav"), "--model", at("gtf.safetensors"), "--speaker-box", "0.5,0,0.2,1"}, "empty");
  write_gtf_file(at("bare.safetensors"), 0, false);
  expect_refused({at("sound.wav"), "--model", at("bare.safetensors")}, "no geometry");
  ASSERT_EQ(::setenv("EARPOINT_MODELS_DIR", folder_.c_str(), 1), 0);
  fs::remove(folder_ / "gtf.safetensors");
  expect_refused({at("sound.wav")}, "--model");
  ::unsetenv("EARPOINT_MODELS_DIR");
}

}  // namespace
}  // namespace earpoint

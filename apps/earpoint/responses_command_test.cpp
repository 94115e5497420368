#include "run_program.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/dataset/raf.h>
#include <earpoint/dataset_testing/tiny_published.h>
#include <earpoint/scene/import.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class ResponsesCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    room_ = fs::path(testing::TempDir()) /
            (std::string("responses_command_") +
             testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(room_);
    write_tiny_raf(room_);
  }
  void TearDown() override { fs::remove_all(room_); }

  [[nodiscard]] ProgramOutcome run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"responses", "--data", room_.string()});
    return run_earpoint(arguments);
  }
  [[nodiscard]] nlohmann::json json_of(std::vector<std::string> arguments) const {
    arguments.emplace_back("--json");
    const ProgramOutcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return nlohmann::json::parse(outcome.output);
  }

  fs::path room_;
};

TEST_F(ResponsesCommand, ListsPlacesAsTraceTakesThem) {
  const ProgramOutcome outcome = run({});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.output,
            "000005  source 2,0,1,yaw=180  listener 0,2.5,1.5\n"
            "000007  source 2,0,1,yaw=180  listener 0,3.5,1.5\n");
  const nlohmann::json json = json_of({"--limit", "1", "--split", "all"});
  EXPECT_EQ(json.at("items").size(), 1U);
  EXPECT_EQ(json.at("items")[0].at("listener"), "0,0,1.5");
}

TEST_F(ResponsesCommand, PlacesAreInTheFrameOfTheRoomsModel) {
  write_file(room_ / "room.obj", std::string_view("v 1 2 3\nv 4 5 7\nv 6 2 1\nf 1 2 3\n"));
  const Scene scene = import_scene(room_ / "room.obj").scene;
  const Vector3 place = position_from_raf({4.0, 5.0, 7.0});
  const std::array<float, 3> expected{static_cast<float>(place.x), static_cast<float>(place.y),
                                      static_cast<float>(place.z)};
  EXPECT_NE(std::ranges::find(scene.mesh.positions, expected), scene.mesh.positions.end());
}

TEST_F(ResponsesCommand, EstimatesThatAreTheTruthHaveNoError) {
  const fs::path estimates = room_ / "estimates";
  fs::create_directories(estimates);
  for (const char* id : {"000005", "000007"}) {
    fs::copy_file(room_ / "data" / id / "rir.wav", estimates / (std::string(id) + ".wav"));
  }
  for (const char* convention : {"raf", "naf", "avr", "iso"}) {
    const nlohmann::json json =
        json_of({"--estimates", estimates.string(), "--convention", convention});
    EXPECT_EQ(json.at("items"), 2);
    EXPECT_EQ(json.at("convention"), convention);
    for (const auto& [key, value] : json.items()) {
      if (!value.is_number_float()) continue;
      EXPECT_EQ(value, 0.0) << convention << " " << key;
    }
  }
  fs::remove(estimates / "000007.wav");
  const ProgramOutcome outcome = run({"--estimates", estimates.string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  EXPECT_NE(outcome.errors.find("000007.wav: no such file"), std::string::npos) << outcome.errors;
}

TEST_F(ResponsesCommand, TheNearestResponseOfTrainingIsABaseline) {
  const nlohmann::json json = json_of({"--nearest"});
  // 000004 for 000005 and 000006 for 000007: T60 of 0.38 s for 0.4 s and of 0.42 s for 0.44 s, 5 %.
  // Noise moves the time between -5 and -15 dB by some percent more.
  EXPECT_GT(json.at("t60_error_percent").get<double>(), 0.5);
  EXPECT_LT(json.at("t60_error_percent").get<double>(), 15.0);
  EXPECT_GT(json.at("stft_error").get<double>(), 0.1);
  EXPECT_EQ(json.at("items"), 2);
  EXPECT_EQ(run({"--nearest", "--estimates", "out"}).exit_code, 2);
}

TEST_F(ResponsesCommand, AFolderThatIsNoRoomGivesOneLine) {
  const ProgramOutcome outcome =
      run_earpoint({"responses", "--data", (room_ / "metadata").string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  EXPECT_NE(outcome.errors.find("holds no folder data"), std::string::npos) << outcome.errors;
}

}  // namespace

}  // namespace earpoint

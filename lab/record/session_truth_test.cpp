#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/record/session_truth.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

fs::path scratch(const char* name) {
  const fs::path folder = fs::path(::testing::TempDir()) / "session_truth_test";
  fs::create_directories(folder);
  return folder / name;
}

TEST(SessionTruth, IsReadAsItWasWritten) {
  SessionTruth truth;
  truth.cameras = {{"1", 0.0, 0.0}, {"2", -1.25, 12.5}};
  truth.microphones = {{"anna", 0.75, -20.0}};
  truth.people = {{"anna", {{0.0, {1, 2, 1.5}, 0.5}, {0.5, {1.25, 2, 1.5}, 0.75}}, {{0.5, 2.0}}}};
  const fs::path path = scratch("truth.json");
  write_session_truth(path, truth);
  const SessionTruth read = read_session_truth(path);
  EXPECT_EQ(read.cameras, truth.cameras);
  EXPECT_EQ(read.microphones, truth.microphones);
  ASSERT_EQ(read.people.size(), 1U);
  EXPECT_EQ(read.people[0].speech, truth.people[0].speech);
  ASSERT_EQ(read.people[0].track.size(), 2U);
  EXPECT_EQ(read.people[0].track[1].mouth_m, truth.people[0].track[1].mouth_m);
  // Headings go through degrees: two roundings of a double.
  EXPECT_NEAR(read.people[0].track[1].yaw_rad, 0.75, 1e-15);
}

TEST(SessionTruth, AFastClockCountsMoreSecondsThanPassed) {
  const DeviceClock clock{"1", 2.0, 100.0};
  EXPECT_NEAR(device_time_s(clock, 1002.0) - 1000.0, 0.1, 1e-9);
  EXPECT_NEAR(session_time_s(clock, device_time_s(clock, 77.0)), 77.0, 1e-12);
}

TEST(SessionTruth, NamesTheFieldOfATimeThatGoesBack) {
  const fs::path path = scratch("back.json");
  write_file(path, std::string_view(R"({"format": "earpoint-session-truth-1", "cameras": [],
    "microphones": [], "people": [{"name": "anna", "speech": [], "track": [
    {"time_s": 1, "mouth_m": [0, 0, 1], "yaw_deg": 0},
    {"time_s": 0, "mouth_m": [0, 0, 1], "yaw_deg": 0}]}]})"));
  try {
    static_cast<void>(read_session_truth(path));
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("people[0].track[1].time_s"), std::string::npos)
        << error.what();
  }
}

TEST(PersonBoxes, AreReadAsTheyWereWritten) {
  const std::vector<PersonBox> boxes{{.camera = 3,
                                      .frame = 17,
                                      .time_s = 0.5625,
                                      .person = 1,
                                      .box = {.x_min = 0.125, .y_min = 0, .x_max = 0.5, .y_max = 1},
                                      .visible = 0.75}};
  const fs::path path = scratch("boxes.csv");
  write_person_boxes(path, boxes);
  const std::vector<PersonBox> read = read_person_boxes(path);
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].camera, 3);
  EXPECT_EQ(read[0].frame, 17);
  EXPECT_EQ(read[0].time_s, 0.5625);
  EXPECT_EQ(read[0].person, 1);
  EXPECT_EQ(read[0].box, boxes[0].box);
  EXPECT_EQ(read[0].visible, 0.75);
}

}  // namespace
}  // namespace earpoint

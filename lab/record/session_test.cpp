#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/record/session.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

fs::path scratch() {
  fs::path folder = fs::path(::testing::TempDir()) / "session_test" / "SC-7";
  fs::create_directories(folder);
  return folder;
}

Session read_text(const std::string& text) {
  const fs::path path = scratch() / "session.json";
  write_file(path, std::string_view(text));
  return read_session(path);
}

/// A session's JSON with the fields `more`, and `camera` in its first camera.
std::string session_with(const std::string& more, const std::string& camera = "") {
  return R"({"format": "earpoint-session-1", )" + more +
         R"("cameras": [{"name": "1", "video": "a.mp4")" + camera +
         R"(}, {"name": "2", "video": "b.mp4"}]})";
}

void expect_near(const Vector3& a, const Vector3& b) {
  // Rounding of a few products of doubles near 1.
  EXPECT_LT(norm(a - b), 1e-12) << a.x << " " << a.y << " " << a.z;
}

TEST(Session, IsReadAsItWasWritten) {
  Session session;
  session.scene = "SC-7";
  session.split = "val";
  session.cameras.resize(2);
  session.cameras[0] = {.name = "1",
                        .video = scratch() / "media" / "1.mp4",
                        .lens = Lens{640, 360, 500, 501, 320, 180, {0.1, -0.2, 0, 0}},
                        .world_from_camera = Pose{
                            {1, 2, 3}, quaternion_from_euler({.yaw_rad = 2, .pitch_rad = -0.3})}};
  session.cameras[1] = {
      .name = "2", .video = "/elsewhere/2.mp4", .lens = {}, .world_from_camera = {}};
  session.people = {{"anna", scratch() / "anna.wav", 0.3}};
  session.boxes = scratch() / "boxes.csv";
  session.clap_s = 1.5;
  session.clap_m = Vector3{0, 1, 1};
  const fs::path path = scratch() / "written.json";
  write_session(path, session);
  const Session read = read_session(path);
  EXPECT_EQ(read.scene, "SC-7");
  EXPECT_EQ(read.split, "val");
  ASSERT_EQ(read.cameras.size(), 2U);
  EXPECT_EQ(read.cameras[0].video, session.cameras[0].video);
  EXPECT_EQ(read.cameras[1].video, "/elsewhere/2.mp4");
  EXPECT_EQ(read.cameras[0].lens, session.cameras[0].lens);
  const Pose& pose = *read.cameras[0].world_from_camera;
  expect_near(pose.position_m, {1, 2, 3});
  expect_near(rotate(pose.orientation, {1, 0, 0}),
              rotate(session.cameras[0].world_from_camera->orientation, {1, 0, 0}));
  EXPECT_FALSE(read.cameras[1].world_from_camera);
  ASSERT_EQ(read.people.size(), 1U);
  EXPECT_EQ(read.people[0].near, session.people[0].near);
  EXPECT_EQ(read.people[0].near_distance_m, 0.3);
  EXPECT_EQ(read.boxes, session.boxes);
  EXPECT_EQ(read.clap_s, 1.5);
  EXPECT_EQ(read.clap_m, session.clap_m);
}

TEST(Session, OpenCvExtrinsicsMapTheWorldToTheCamera) {
  // A camera at (100, 200, 150) cm that looks along y: right is x, down is -z.
  const Session session = read_text(session_with(
      R"("units": "cm", "frame": "opencv", )",
      R"(, "extrinsics": {"rotation": [[1,0,0],[0,0,-1],[0,1,0]], "translation": [-100, 150, -200]})"));
  const Pose& pose = *session.cameras[0].world_from_camera;
  expect_near(pose.position_m, {1, 2, 1.5});
  expect_near(rotate(pose.orientation, {1, 0, 0}), {0, 1, 0});
  expect_near(rotate(pose.orientation, {0, 1, 0}), {-1, 0, 0});
  expect_near(rotate(pose.orientation, {0, 0, 1}), {0, 0, 1});
}

TEST(Session, TheAxisThatPointsUpBecomesZ) {
  for (const auto& [up, above] : {std::pair{"x", "[1, 0, 0]"}, std::pair{"-x", "[-1, 0, 0]"},
                                  std::pair{"y", "[0, 1, 0]"}, std::pair{"-y", "[0, -1, 0]"},
                                  std::pair{"z", "[0, 0, 1]"}, std::pair{"-z", "[0, 0, -1]"}}) {
    const Session session = read_text(session_with(std::string(R"("units": 2, "up": ")") + up +
                                                   R"(", "clap_position": )" + above + ", "));
    expect_near(*session.clap_m, {0, 0, 2});
  }
}

TEST(Session, TakesPosesAndLensesFromColmap) {
  const fs::path folder = scratch() / "sparse";
  fs::create_directories(folder);
  write_file(folder / "cameras.txt",
             std::string_view("# Camera list\n3 RADIAL 640 480 500 320 240 0.1 0.01\n"));
  // The camera of the test before, in a world whose y axis points down: (x, y, z) becomes (x, -z,
  // y), so that it looks along z with x to the right and y down: no rotation.
  write_file(folder / "images.txt",
             std::string_view("# Image list\n7 1 0 0 0 -1 1.5 -2 3 shots/1.jpg\n\n"));
  const Session session =
      read_text(session_with(R"("up": "-y", "calibration": {"colmap": "sparse"}, )"));
  const Pose& pose = *session.cameras[0].world_from_camera;
  expect_near(pose.position_m, {1, 2, 1.5});
  expect_near(rotate(pose.orientation, {1, 0, 0}), {0, 1, 0});
  expect_near(rotate(pose.orientation, {0, 1, 0}), {-1, 0, 0});
  EXPECT_EQ(session.cameras[0].lens, (Lens{640, 480, 500, 500, 320, 240, {0.1, 0.01, 0, 0}}));
  EXPECT_FALSE(session.cameras[1].world_from_camera);
}

TEST(Session, TakesPosesFromTheAuthorsCameraFile) {
  write_file(scratch() / "positions.json", std::string_view(R"({
    "centers": {"SC-7": {"DSLR-1": [100, 200, 150], "DSLR-2": [NaN, NaN, NaN]}},
    "rotations": {"SC-7": {"DSLR-1": [0, 1, 0], "DSLR-2": [NaN, NaN, NaN]}}})"));
  const Session session =
      read_text(session_with(R"("calibration": {"camera_positions": "positions.json"}, )"));
  expect_near(session.cameras[0].world_from_camera->position_m, {1, 2, 1.5});
  expect_near(rotate(session.cameras[0].world_from_camera->orientation, {1, 0, 0}), {0, 1, 0});
  EXPECT_FALSE(session.cameras[1].world_from_camera);
}

TEST(Session, EveryErrorNamesTheField) {
  const std::pair<std::string, const char*> cases[] = {
      {R"({"format": "earpoint-session-2", "cameras": []})", "session.json: format:"},
      {R"({"format": "earpoint-session-1"})", "'cameras' is missing"},
      {R"({"format": "earpoint-session-1", "cameras": []})", "session.json: cameras:"},
      {session_with(R"("clap": 1, )"), "session.json: clap:"},
      {session_with(R"("units": "feet", )"), "session.json: units:"},
      {session_with(R"("frame": "unity", )"), "session.json: frame:"},
      {session_with(R"("up": "w", )"), "session.json: up:"},
      {session_with(R"("split": "dev", )"), "session.json: split:"},
      {session_with(R"("clap_s": -1, )"), "session.json: clap_s:"},
      {session_with(R"("people": [{"name": "1", "near": "x.wav"}], )"),
       "session.json: people[0].name:"},
      {session_with(R"("people": [{"name": "anna"}], )"), "'near' is missing"},
      {session_with(R"("people": [{"name": "a", "near": "a.wav", "near_distance_m": -1}], )"),
       "session.json: people[0].near_distance_m:"},
      {session_with(R"("people": [{"name": "a"}], "microphones": ["x.wav"], )"),
       "boxes too, which show who wears which"},
      {session_with(R"("people": [], "boxes": "b.csv", "microphones": ["x.wav"], )"),
       "session.json: microphones:"},
      {session_with(R"("people": [{"name": "a", "near": "a.wav"}], "boxes": "b.csv",
                        "microphones": ["x.wav"], )"),
       "session.json: people[0].near:"},
      {session_with("", R"(, "intrinsics": {"width": 1})"), "session.json: cameras[0].intrinsics:"},
      {session_with("", R"(, "intrinsics": {"width": 0, "height": 1, "fx": 1, "fy": 1, "cx": 1,
                        "cy": 1})"),
       "session.json: cameras[0].intrinsics.width:"},
      {session_with("", R"(, "intrinsics": {"width": 1, "height": 1, "fx": 1, "fy": 1, "cx": 1,
                        "cy": 1, "distortion": [1]})"),
       "session.json: cameras[0].intrinsics.distortion:"},
      {session_with("", R"(, "extrinsics": {"rotation": [[1,0,0],[0,1,0],[0,0,2]],
                        "translation": [0,0,0]})"),
       "session.json: cameras[0].extrinsics.rotation:"},
      {session_with("", R"(, "extrinsics": {"rotation": [[1,0,0],[0,1,0],[0,0,-1]],
                        "translation": [0,0,0]})"),
       "not a mirror image"},
      {session_with(R"("calibration": {"colmap": "nowhere"}, )"),
       "session.json: calibration.colmap:"},
  };
  for (const auto& [text, expected] : cases) {
    try {
      static_cast<void>(read_text(text));
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace earpoint

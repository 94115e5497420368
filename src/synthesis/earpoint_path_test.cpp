#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/synthesis/speaker_track.h>

namespace earpoint {
namespace {

constexpr const char* kHeader = "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n";

std::string message(const std::function<void()>& body) {
  try {
    body();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(EarpointPath, MovesLinearlyAndTurnsAlongTheShorterArc) {
  const auto path =
      EarpointPath::parse_csv(std::string(kHeader) + "0,0,0,0,170,0,0\n2,4,0,1,-170,0,0\n", "w");
  const Pose pose = path.at(0.5);
  // Doubles through one product and one slerp.
  EXPECT_NEAR(pose.position_m.x, 1.0, 1e-12);
  EXPECT_NEAR(pose.position_m.z, 0.25, 1e-12);
  EXPECT_NEAR(degrees_from_radians(euler_from_quaternion(pose.orientation).yaw_rad), 175, 1e-9);
  EXPECT_EQ(path.at(-1).position_m, (Vector3{0, 0, 0}));
  EXPECT_EQ(path.at(9).position_m, (Vector3{4, 0, 1}));
}

TEST(EarpointPath, RefusesGapsAndDisorder) {
  EXPECT_EQ(message([] {
              (void)EarpointPath::parse_csv(std::string(kHeader) + "0,0,0,,0,0,0\n", "walk.csv");
            }),
            "walk.csv: line 2, z: the cell is empty; give a number");
  EXPECT_EQ(message([] {
              (void)EarpointPath::parse_csv(std::string(kHeader) + "1,0,0,0,0,0,0\n1,0,0,0,0,0,0\n",
                                            "walk.csv");
            }),
            "walk.csv: line 3: time 1 s does not come after 1 s");
}

TEST(EarpointPath, RefusesPlacesAndAnglesBeyondHearing) {
  EXPECT_EQ(
      message([] {
        (void)EarpointPath::parse_csv(std::string(kHeader) + "0,0,2e4,0,0,0,0\n", "walk.csv");
      }),
      "walk.csv: line 2: 20000 m is farther than the limit of 10000 m; positions are in metres "
      "from the camera");
  EXPECT_EQ(message([] {
              (void)EarpointPath::parse_csv(std::string(kHeader) + "0,0,0,0,1e9,0,0\n", "walk.csv");
            }),
            "walk.csv: line 2: expected an angle in degrees, found 1e+09");
  EXPECT_NE(message([] {
              (void)parse_poses_json(R"({"position_m": [0, -1e5, 0]})", "p.json");
            }).find("p.json: -100000 m is farther"),
            std::string::npos);
  EXPECT_NE(message([] {
              (void)parse_poses_json(
                  R"({"position_m": [0, 1e300, 0], "quaternion_wxyz": [1, 0, 0, 0]})", "p.json");
            }).find("is farther"),
            std::string::npos);
}

TEST(EarpointPath, MustCoverTheClip) {
  const auto path =
      EarpointPath::parse_csv(std::string(kHeader) + "0,0,0,0,0,0,0\n3,1,0,0,0,0,0\n", "walk.csv");
  path.check_covers(3.2);
  EXPECT_EQ(message([&] { path.check_covers(5.0); }),
            "walk.csv: the path ends at 3.000 s, the clip at 5.000 s; add a row for 5.000 s");
  const auto late =
      EarpointPath::parse_csv(std::string(kHeader) + "1,0,0,0,0,0,0\n3,1,0,0,0,0,0\n", "walk.csv");
  EXPECT_EQ(message([&] { late.check_covers(3.0); }),
            "walk.csv: the path starts at 1 s, the clip at 0 s; add a row for 0 s");
  EarpointPath(Pose{}).check_covers(100.0);
}

TEST(PoseJson, ReadsAnglesQuaternionsAndLists) {
  const auto poses = parse_poses_json(
      R"([{"position_m": [1, -0.5, 0], "yaw_deg": 90},
          {"position_m": [0, 0, 0], "quaternion_wxyz": [0.70710678, 0, 0, 0.70710678]}])",
      "to.json");
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].position_m.y, -0.5);
  for (const Pose& pose : poses) {
    // The file's quaternion has eight digits.
    EXPECT_NEAR(euler_from_quaternion(pose.orientation).yaw_rad, kPi / 2, 1e-7);
  }
}

TEST(PoseJson, NamesWhatIsWrong) {
  const auto of = [](const char* text) {
    return message([&] { (void)parse_poses_json(text, "to.json"); });
  };
  EXPECT_EQ(of("{"), "to.json: is not valid JSON");
  EXPECT_EQ(of("[]"), "to.json: lists no pose");
  EXPECT_EQ(of("{}"), "to.json: position_m is missing");
  EXPECT_EQ(of(R"({"position_m": [1, 2]})"),
            "to.json, position_m: expected 3 numbers, found [1,2]");
  EXPECT_EQ(of(R"([{"position_m": [1, 2, null]}])"),
            "to.json: pose 1, position_m: expected a finite number, found null");
  EXPECT_EQ(of(R"({"position_m": [0,0,0], "yaw": 3})"),
            "to.json: unknown field 'yaw'; known are position_m, yaw_deg, pitch_deg, roll_deg, "
            "quaternion_wxyz");
  EXPECT_EQ(of(R"({"position_m": [0,0,0], "quaternion_wxyz": [2,0,0,0]})"),
            "to.json, quaternion_wxyz: its length is 2, not 1");
  EXPECT_EQ(of(R"({"position_m": [0,0,0], "quaternion_wxyz": [1,0,0,0], "yaw_deg": 1})"),
            "to.json: give either quaternion_wxyz or angles");
}

TEST(SpeakerTrack, GivesTheNearestBox) {
  const auto track =
      SpeakerTrack::parse_csv("time_s,x0,y0,x1,y1\n0,0,0,0.5,1\n2,0.5,0,1,1\n", "boxes.csv");
  EXPECT_EQ(track.at(-1)->x_min, 0.0);
  EXPECT_EQ(track.at(0.9)->x_min, 0.0);
  EXPECT_EQ(track.at(1.1)->x_min, 0.5);
  EXPECT_EQ(track.at(10)->x_min, 0.5);
}

TEST(SpeakerTrack, UnderstandsPixelsWhereThePictureIsKnown) {
  const SpeakerTrack::PictureSize picture = std::array{640, 480};
  EXPECT_EQ(SpeakerTrack(Box{64, 48, 320, 480}, picture).at(0), (Box{0.1, 0.1, 0.5, 1.0}));
  // All boxes of a file have the same unit: here the first row's 1 is a pixel.
  const auto track = SpeakerTrack::parse_csv("time_s,x0,y0,x1,y1\n0,0,0,1,1\n2,0,0,320,240\n",
                                             "boxes.csv", picture);
  EXPECT_EQ(track.at(0), (Box{0, 0, 1.0 / 640, 1.0 / 480}));
  EXPECT_EQ(track.at(2), (Box{0, 0, 0.5, 0.5}));
  EXPECT_EQ(message([] {
              (void)SpeakerTrack(Box{64, 48, 320, 480});
            }),
            "speaker box: the box is in pixels, but the size of the picture is not known; "
            "give fractions of its width and height, 0 to 1, or the picture");
  EXPECT_NE(message([&] {
              (void)SpeakerTrack(Box{64, 48, 641, 480}, picture);
            }).find("extends beyond the picture"),
            std::string::npos);
}

TEST(SpeakerTrack, ChoosesWhoSpeaksAmongThePeopleOfAFile) {
  const auto track = SpeakerTrack::parse_csv(
      "time_s,track,x0,y0,x1,y1,speaking,voice\n"
      "0,0,0,0,0.2,1,0.1,1\n0,1,0.5,0,0.7,1,0.8,1\n"        // the second
      "1,0,0,0,0.2,1,0.03,0.1\n1,1,0.5,0,0.7,1,0.02,0.1\n"  // silence: still that one
      "2,0,0,0,0.2,1,0.7,0.9\n2,1,0.5,0,0.7,1,0.1,0.9\n"    // the first
      "3,0,0,0,0.2,1,0.1,0.9\n3,1,0.5,0,0.7,1,0.2,0.9\n",   // 0.6 are left for somebody else
      "people.csv");
  EXPECT_EQ(track.at(0)->x_min, 0.5);
  EXPECT_EQ(track.at(1)->x_min, 0.5);
  EXPECT_EQ(track.at(2)->x_min, 0.0);
  EXPECT_EQ(track.at(3), std::nullopt);
  EXPECT_EQ(track.held()->at(3)->x_min, 0.0);
  EXPECT_EQ(SpeakerTrack(std::vector<SpeakerTrack::Row>{{0.0, std::nullopt}}).held(), std::nullopt);
}

TEST(SpeakerTrack, RefusesBoxesOutsideThePictureOrEmpty) {
  EXPECT_EQ(
      message([] {
        (void)SpeakerTrack(Box{-0.1, 0, 0.5, 1});
      }),
      "speaker box: the box -0.1,0,0.5,1 extends beyond the picture; x0,y0,x1,y1 are fractions of "
      "its width and height, or pixels of it");
  EXPECT_EQ(message([] {
              (void)SpeakerTrack::parse_csv("time_s,x0,y0,x1,y1\n0,0.5,0,0.5,1\n", "boxes.csv");
            }),
            "boxes.csv: line 2: the box 0.5,0,0.5,1 is empty; x0 < x1 and y0 < y1 are needed");
}

TEST(EarpointPath, RowsInMemoryMoveAsThoseOfAFile) {
  const EarpointPath file = EarpointPath::parse_csv(
      "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n0,0,0,0,0,0,0\n2,1,-3,0.5,0,0,0\n", "walk.csv");
  using Rows = std::vector<EarpointPath::Row>;
  const EarpointPath rows(Rows{{0.0, {}}, {2.0, {{1, -3, 0.5}, {}}}});
  for (const double time_s : {-1.0, 0.0, 0.7, 2.0, 3.0})
    EXPECT_EQ(rows.at(time_s), file.at(time_s));
  EXPECT_TRUE(rows.is_moving());
  EXPECT_THROW(rows.check_covers(4.0), InputError);
  EXPECT_THROW(EarpointPath{Rows()}, InputError);
  EXPECT_THROW((EarpointPath{Rows{{1.0, {}}, {1.0, {}}}}), InputError);
}

}  // namespace
}  // namespace earpoint

#include <cmath>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/network/pose_encoding.h>
#include <earpoint/pose.h>
#include <earpoint/weights/safetensors.h>
#include <earpoint/weights_testing/reference_folders.h>

namespace earpoint {
namespace {

std::vector<std::filesystem::path> folders() {
  return reference_folders("src/networks/common/testdata", "D_poses");
}

/// Pose in our frame of a SoundSpaces viewpoint: y up, looking along -z at rotation 0, positive
/// rotation to the left.
Pose from_soundspaces(const double* location, double rotation_rad) {
  return {{-location[2], -location[0], location[1]},
          quaternion_from_euler({.yaw_rad = rotation_rad})};
}

TEST(PoseEncoding, SoundspacesEqualsTheReleasedLoader) {
  for (const auto& folder : folders()) {
    const SafetensorsFile file = read_safetensors(folder / "soundspaces.safetensors");
    const auto locations = file.tensors.at("location").as<double>();
    const auto rotations = file.tensors.at("rotation").as<double>();
    const auto poses = file.tensors.at("tgt_pose_sincos").as<float>();
    const auto turns = file.tensors.at("tgt_rotation_sincos").as<float>();
    for (std::size_t i = 0; i < 20; ++i) {
      const Pose source = from_soundspaces(&locations[i * 6], rotations[i * 2]);
      const Pose target = from_soundspaces(&locations[i * 6 + 3], rotations[i * 2 + 1]);
      if (std::hypot(target.position_m.x - source.position_m.x,
                     target.position_m.y - source.position_m.y) == 0.0) {
        // The loader's angle of a coincident point depends on the world's axes, which a relative
        // pose does not contain. The distance of zero makes it irrelevant.
        continue;
      }
      const EncodedPose encoded = encode_pose(PoseEncoding::soundspaces, inverse(source) * target);
      for (std::size_t k = 0; k < 3; ++k) {
        // Rounding to float of numbers up to 10.
        EXPECT_NEAR(encoded.tgt_pose[k], poses[i * 3 + k], 2e-6) << i << ", " << k;
      }
      for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_NEAR(encoded.tgt_rotation[k], turns[i * 2 + k], 2e-6) << i << ", " << k;
      }
    }
  }
}

TEST(PoseEncoding, ReplayEqualsTheReleasedLoaderForASourceThatLooksAlongX) {
  const Pose target{{1.0, 2.0, 0.5}, quaternion_from_euler({.yaw_rad = 0.3, .pitch_rad = 0.2})};
  const EncodedPose encoded = encode_pose(PoseEncoding::replay, target);
  // The loader's own formulas, for centres (0, 0, 0) and (100, 200, 50) cm, directions (1, 0, 0)
  // and v.
  const Vector3 v = rotate(target.orientation, {1, 0, 0});
  const double q = 90.0 - (0.0 - std::atan2(200.0, 100.0));
  const double d = std::hypot(100.0, 200.0);
  const double pose[] = {d * std::cos(q), d * std::sin(q), 50.0};
  const double angles[] = {std::atan2(v.y, v.x), std::atan2(v.z, v.y), std::atan2(v.z, v.x)};
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(encoded.tgt_pose[k], pose[k], 1e-4);  // float rounding of hundreds
    EXPECT_NEAR(encoded.tgt_rotation[2 * k], std::sin(angles[k]), 1e-6);
    EXPECT_NEAR(encoded.tgt_rotation[2 * k + 1], std::cos(angles[k]), 1e-6);
  }
}

/// Where a camera of the Replay recordings stands, from centimetres and a viewing direction.
Pose from_replay(const double* centre, const double* direction) {
  const Vector3 position_m = Vector3{centre[0], centre[1], centre[2]} * 0.01;
  return look_at(position_m, position_m + Vector3{direction[0], direction[1], direction[2]});
}

TEST(PoseEncoding, ReplayEqualsTheReleasedLoaderWhereverTheSourceLooks) {
  for (const auto& folder : folders()) {
    const SafetensorsFile file = read_safetensors(folder / "replay.safetensors");
    const auto centres = file.tensors.at("centers").as<double>();
    const auto directions = file.tensors.at("directions").as<double>();
    const auto pairs = file.tensors.at("pairs").as<std::int64_t>();
    const auto poses = file.tensors.at("fixed_rotrel_tgt_pose").as<double>();
    const auto turns = file.tensors.at("fixed_rotrel_tgt_rotation_sincos").as<float>();
    ASSERT_EQ(pairs.size(), 40U);
    for (std::size_t i = 0; i < 20; ++i) {
      // Cameras are numbered from 1.
      const auto from = 3 * static_cast<std::size_t>(pairs[2 * i] - 1);
      const auto to = 3 * static_cast<std::size_t>(pairs[2 * i + 1] - 1);
      const Pose source = from_replay(&centres[from], &directions[from]);
      const Pose target = from_replay(&centres[to], &directions[to]);
      const EncodedPose encoded =
          encode_pose(PoseEncoding::replay, inverse(source) * target, source);
      for (std::size_t k = 0; k < 3; ++k) {
        // Float rounding of hundreds of centimetres.
        EXPECT_NEAR(encoded.tgt_pose[k], poses[i * 3 + k], 1e-4) << i << ", " << k;
      }
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(encoded.tgt_rotation[k], turns[i * 6 + k], 2e-6) << i << ", " << k;
      }
    }
  }
}

TEST(PoseEncoding, ReplayTakesRoundingOfALevelDirectionForZero) {
  // Looking along x, y, -x and -y, where two components of the direction are zero up to rounding:
  // their sign must not turn an angle of 0 into pi.
  const double directions[4][3] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  const double centre[3] = {100, 200, 150};
  for (const auto& from : directions) {
    for (const auto& to : directions) {
      const Pose source = from_replay(centre, from);
      const EncodedPose encoded =
          encode_pose(PoseEncoding::replay, inverse(source) * from_replay(centre, to), source);
      const double angles[] = {std::atan2(to[1], to[0]) - std::atan2(from[1], from[0]),
                               std::atan2(0.0, to[1]) - std::atan2(0.0, from[1]),
                               std::atan2(0.0, to[0]) - std::atan2(0.0, from[0])};
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(encoded.tgt_rotation[2 * k], std::sin(angles[k]), 1e-6);
        EXPECT_NEAR(encoded.tgt_rotation[2 * k + 1], std::cos(angles[k]), 1e-6);
      }
    }
  }
}

TEST(PoseEncoding, FullKeepsEveryDegreeOfFreedom) {
  const EulerAngles angles{.yaw_rad = 0.4, .pitch_rad = -0.3, .roll_rad = 0.2};
  const EncodedPose encoded =
      encode_pose(PoseEncoding::full, {{1, -2, 0.25}, quaternion_from_euler(angles)});
  EXPECT_EQ(encoded.tgt_pose, (std::vector<float>{1, -2, 0.25}));
  EXPECT_NEAR(encoded.tgt_rotation[0], std::sin(0.4), 1e-7);
  EXPECT_NEAR(encoded.tgt_rotation[3], std::cos(-0.3), 1e-7);
  EXPECT_NEAR(encoded.tgt_rotation[4], std::sin(0.2), 1e-7);
}

TEST(BoxEncoding, SoundspacesIsFirstAndLastPixelOver255) {
  // Rows 32 to 127 and columns 64 to 191 of 256.
  const Box box{64 / 256.0, 32 / 256.0, 192 / 256.0, 128 / 256.0};
  EXPECT_EQ(encode_box(BoxEncoding::soundspaces, box),
            (std::vector<float>{32 / 255.0F, 127 / 255.0F, 64 / 255.0F, 191 / 255.0F}));
  // The whole picture is from 0 to 1.
  EXPECT_EQ(encode_box(BoxEncoding::soundspaces, Box{0, 0, 1, 1}),
            (std::vector<float>{0, 1, 0, 1}));
}

TEST(BoxEncoding, CornersAreTheFractions) {
  const Box box{0.1, 0.2, 0.3, 0.4};
  EXPECT_EQ(encode_box(BoxEncoding::corners, box), (std::vector<float>{0.1F, 0.2F, 0.3F, 0.4F}));
}

TEST(BoxEncoding, TellsMiddleAndHeightInNumbersOfLikeSpread) {
  const std::vector<float> seen = encode_box(BoxEncoding::centre, Box{0.5, 0.25, 1.0, 0.75});
  ASSERT_EQ(seen.size(), 4);
  EXPECT_EQ(seen[0], 1.0F);
  EXPECT_FLOAT_EQ(seen[1], 1.0F);  // its middle is at three quarters of the width
  EXPECT_FLOAT_EQ(seen[2], 0.0F);
  EXPECT_FLOAT_EQ(seen[3], 0.0F);  // half as high as the picture
  // Twice as far away, half as high.
  EXPECT_NEAR(encode_box(BoxEncoding::centre, Box{0.5, 0.375, 0.75, 0.625})[3],
              -2.0 * std::log(2.0), 1e-6);
}

TEST(BoxEncoding, SaysNothingOfASpeakerOutOfSight) {
  for (const BoxEncoding encoding :
       {BoxEncoding::soundspaces, BoxEncoding::corners, BoxEncoding::centre}) {
    EXPECT_EQ(encode_box(encoding, std::optional<Box>()), std::vector<float>(4));
  }
}

TEST(BoxEncoding, TakesABoxWithoutHeightForNobody) {
  EXPECT_EQ(encode_box(BoxEncoding::centre, Box{}), std::vector<float>(4));
  EXPECT_EQ(encode_box(BoxEncoding::centre, Box{0.2, 0.5, 0.2, 0.5}), std::vector<float>(4));
}

}  // namespace
}  // namespace earpoint

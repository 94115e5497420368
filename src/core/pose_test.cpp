#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

// A handful of double-precision products of numbers of order 1 to 10.
constexpr double kTolerance = 1e-12;

void expect_near(const Vector3& actual, const Vector3& expected) {
  EXPECT_NEAR(actual.x, expected.x, kTolerance);
  EXPECT_NEAR(actual.y, expected.y, kTolerance);
  EXPECT_NEAR(actual.z, expected.z, kTolerance);
}

Pose random_pose(RandomStream& random) {
  return {
      {random.normal(), random.normal(), random.normal()},
      normalized(Quaternion{random.normal(), random.normal(), random.normal(), random.normal()})};
}

TEST(Pose, PositiveYawTurnsTheFrontToTheLeft) {
  const Quaternion q = quaternion_from_euler({.yaw_rad = kPi / 2});
  expect_near(rotate(q, {1, 0, 0}), {0, 1, 0});
}

TEST(Pose, PositivePitchLiftsTheFront) {
  const Quaternion q = quaternion_from_euler({.pitch_rad = kPi / 2});
  expect_near(rotate(q, {1, 0, 0}), {0, 0, 1});
}

TEST(Pose, PositiveRollLowersTheRightEar) {
  const Quaternion q = quaternion_from_euler({.roll_rad = kPi / 2});
  expect_near(rotate(q, {0, -1, 0}), {0, 0, -1});
}

TEST(Pose, LeftIsAtPositiveAzimuth) {
  EXPECT_NEAR(spherical_from_cartesian({0, 2, 0}).azimuth_rad, kPi / 2, kTolerance);
  EXPECT_NEAR(spherical_from_cartesian({0, 0, 3}).elevation_rad, kPi / 2, kTolerance);
  expect_near(cartesian_from_spherical(spherical_from_cartesian({1, -2, 3})), {1, -2, 3});
}

TEST(Pose, EulerAnglesSurviveTheRoundTrip) {
  RandomStream random(1);
  for (int i = 0; i < 100; ++i) {
    const EulerAngles angles{random.uniform(-3, 3), random.uniform(-1.5, 1.5),
                             random.uniform(-3, 3)};
    const EulerAngles back = euler_from_quaternion(quaternion_from_euler(angles));
    // asin loses half the digits where the pitch nears 90 degrees.
    EXPECT_NEAR(back.yaw_rad, angles.yaw_rad, 1e-7);
    EXPECT_NEAR(back.pitch_rad, angles.pitch_rad, 1e-7);
    EXPECT_NEAR(back.roll_rad, angles.roll_rad, 1e-7);
  }
}

TEST(Pose, StraightUpStillGivesTheSameTurn) {
  const Quaternion q = quaternion_from_euler({.yaw_rad = 0.7, .pitch_rad = kPi / 2});
  const Quaternion back = quaternion_from_euler(euler_from_quaternion(q));
  const Vector3 left = rotate(q, {0, 1, 0});
  const Vector3 left_back = rotate(back, {0, 1, 0});
  // asin loses half the digits, as above.
  EXPECT_NEAR(norm(left - left_back), 0.0, 1e-7);
}

TEST(Pose, CompositionAppliesTheRightOneFirst) {
  RandomStream random(2);
  const Pose world_from_room = random_pose(random);
  const Pose room_from_listener = random_pose(random);
  const Vector3 point{0.3, -1.2, 2.0};
  expect_near(transform_point(world_from_room * room_from_listener, point),
              transform_point(world_from_room, transform_point(room_from_listener, point)));
}

TEST(Pose, InverseUndoes) {
  RandomStream random(3);
  const Pose pose = random_pose(random);
  expect_near(transform_point(inverse(pose) * pose, {1, 2, 3}), {1, 2, 3});
}

TEST(Pose, SlerpTakesTheShorterArcAtConstantSpeed) {
  const Quaternion a = quaternion_from_euler({.yaw_rad = radians_from_degrees(170)});
  const Quaternion b = quaternion_from_euler({.yaw_rad = radians_from_degrees(-170)});
  const EulerAngles quarter = euler_from_quaternion(slerp(a, b, 0.25));
  EXPECT_NEAR(quarter.yaw_rad, radians_from_degrees(175), kTolerance);
  const Quaternion minus_b{-b.w, -b.x, -b.y, -b.z};
  EXPECT_NEAR(euler_from_quaternion(slerp(a, minus_b, 0.25)).yaw_rad, radians_from_degrees(175),
              kTolerance);
}

TEST(Pose, LookAtPutsTheTargetStraightAhead) {
  const Vector3 target{-1, 4, 2};
  const Pose world_from_viewer = look_at({2, 1, 0.5}, target);
  const Vector3 seen = transform_point(inverse(world_from_viewer), target);
  expect_near(seen, {norm(target - world_from_viewer.position_m), 0, 0});
  EXPECT_NEAR(rotate(world_from_viewer.orientation, {0, 1, 0}).z, 0.0, kTolerance);
}

TEST(Pose, WrappedAnglesLieAboveMinusPiAndUpToPi) {
  EXPECT_NEAR(wrap_angle(3 * kPi), kPi, kTolerance);
  EXPECT_NEAR(wrap_angle(-kPi), kPi, kTolerance);
  EXPECT_NEAR(wrap_angle(-0.1 - 4 * kPi), -0.1, kTolerance);
}

}  // namespace
}  // namespace earpoint

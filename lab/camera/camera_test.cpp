#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include <earpoint/camera/camera.h>

namespace earpoint {
namespace {

// Closed forms in double: what is left is rounding.
constexpr double kRounding = 1e-9;

TEST(Camera, SeesTheAxisInTheMiddleOfThePicture) {
  const Camera camera{.width = 256, .height = 192};
  const auto pixel = project(camera, {3.0, 0.0, 0.0});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x, 128.0, kRounding);
  EXPECT_NEAR(pixel->y, 96.0, kRounding);
}

TEST(Camera, LeftIsLeftAndUpIsUp) {
  const Camera camera{};
  EXPECT_LT(project(camera, {3.0, 1.0, 0.0})->x, 128.0);
  EXPECT_GT(project(camera, {3.0, -1.0, 0.0})->x, 128.0);
  EXPECT_LT(project(camera, {3.0, 0.0, 1.0})->y, 128.0);
  EXPECT_GT(project(camera, {3.0, 0.0, -1.0})->y, 128.0);
}

TEST(Camera, TurningLeftMovesThePictureRight) {
  const Camera camera{
      .world_from_camera = {{}, quaternion_from_euler({.yaw_rad = radians_from_degrees(30)})}};
  EXPECT_GT(project(camera, {3.0, 0.0, 0.0})->x, 128.0);
}

TEST(Camera, LookingUpMovesThePictureDown) {
  const Camera camera{
      .world_from_camera = {{}, quaternion_from_euler({.pitch_rad = radians_from_degrees(20)})}};
  EXPECT_GT(project(camera, {3.0, 0.0, 0.0})->y, 128.0);
}

TEST(Camera, FieldOfViewEndsAtTheEdges) {
  const Camera camera{.horizontal_fov_rad = radians_from_degrees(90), .width = 384, .height = 216};
  EXPECT_NEAR(project(camera, {2.0, 2.0, 0.0})->x, 0.0, kRounding);
  EXPECT_NEAR(project(camera, {2.0, -2.0, 0.0})->x, 384.0, kRounding);
  const double vertical = vertical_fov_rad(camera);
  EXPECT_NEAR(std::tan(vertical / 2.0), 216.0 / 384.0, kRounding);
  EXPECT_NEAR(project(camera, {1.0, 0.0, std::tan(vertical / 2.0)})->y, 0.0, kRounding);
}

TEST(Camera, DirectionOfAPixelLeadsBackToIt) {
  const Camera camera{.world_from_camera = look_at({1.0, 2.0, 1.5}, {-2.0, 0.5, 0.3}),
                      .horizontal_fov_rad = radians_from_degrees(75),
                      .width = 100,
                      .height = 60};
  const Vector3 direction = direction_of_pixel(camera, {17.25, 44.5});
  EXPECT_EQ(direction.x, 1.0);
  const auto pixel = project(camera, transform_point(camera.world_from_camera, direction * 2.5));
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x, 17.25, kRounding);
  EXPECT_NEAR(pixel->y, 44.5, kRounding);
}

TEST(Camera, DoesNotSeeBehindItself) {
  EXPECT_FALSE(project(Camera{}, {-1.0, 0.2, 0.1}));
  EXPECT_FALSE(project(Camera{}, {0.0, 1.0, 0.0}));
}

TEST(Camera, RefusesWhatIsNoCamera) {
  EXPECT_THROW(check_camera({.width = 0}), std::logic_error);
  EXPECT_THROW(check_camera({.horizontal_fov_rad = kPi}), std::logic_error);
  EXPECT_THROW(check_camera({.horizontal_fov_rad = 0.0}), std::logic_error);
  EXPECT_THROW(check_camera({.horizontal_fov_rad = std::nan("")}), std::logic_error);
  EXPECT_NO_THROW(check_camera({}));
}

}  // namespace
}  // namespace earpoint

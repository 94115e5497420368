#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/spatial/speaker_direction.h>

namespace earpoint {
namespace {

constexpr double kFov = kPi / 2;
constexpr double kCameraHeight_m = 1.5;

// The box that a level camera 1.5 m above the floor sees around an upright body: a vertical
// elliptic cylinder, 0.45 m wide and 0.25 m deep, whose feet are at (x, y). Cut at the picture.
Box box_of_person(double x_m, double y_m, double height_m, int width_px, int height_px) {
  const double half_width = std::tan(kFov / 2);
  const double half_height = half_width * height_px / width_px;
  Box box{1.0, 1.0, 0.0, 0.0};
  for (int step = 0; step < 360; ++step) {
    const double angle = radians_from_degrees(step);
    const double x = x_m + 0.125 * std::cos(angle);
    const double y = y_m + 0.225 * std::sin(angle);
    for (const double z : {-kCameraHeight_m, height_m - kCameraHeight_m}) {
      const double column = 0.5 - y / x / half_width / 2.0;
      const double row = 0.5 - z / x / half_height / 2.0;
      box.x_min = std::min(box.x_min, column);
      box.x_max = std::max(box.x_max, column);
      box.y_min = std::min(box.y_min, row);
      box.y_max = std::max(box.y_max, row);
    }
  }
  box.x_min = std::clamp(box.x_min, 0.0, 1.0);
  box.x_max = std::clamp(box.x_max, 0.0, 1.0);
  box.y_min = std::clamp(box.y_min, 0.0, 1.0);
  box.y_max = std::clamp(box.y_max, 0.0, 1.0);
  return box;
}

Vector3 mouth_of_person(double x_m, double y_m, double height_m) {
  return {x_m, y_m, height_m - 0.18 - kCameraHeight_m};
}

TEST(SpeakerDirection, FindsAPersonWhoIsWhollySeen) {
  for (const double x_m : {2.0, 3.0, 5.0, 8.0}) {
    for (const double lateral : {-0.6, -0.2, 0.0, 0.3, 0.7}) {
      const Box box = box_of_person(x_m, lateral * x_m, 1.7, 256, 256);
      ASSERT_LT(box.y_max, 0.995);
      const Spherical found = speaker_direction_from_box(box, kFov, 256, 256);
      const Spherical truth = spherical_from_cartesian(mouth_of_person(x_m, lateral * x_m, 1.7));
      // The body's depth of 0.25 m makes the box larger than for the flat person assumed: up to
      // 0.125 m closer than the axis, and up to 0.5 degrees off its middle.
      EXPECT_NEAR(found.distance_m, truth.distance_m, 0.2);
      EXPECT_NEAR(degrees_from_radians(found.azimuth_rad - truth.azimuth_rad), 0.0, 0.8);
      EXPECT_NEAR(degrees_from_radians(found.elevation_rad - truth.elevation_rad), 0.0, 1.5);
    }
  }
}

TEST(SpeakerDirection, LeftInThePictureIsPositiveAzimuth) {
  const Spherical found = speaker_direction_from_box({0.1, 0.3, 0.2, 0.8}, kFov, 256, 256);
  EXPECT_GT(found.azimuth_rad, 0.5);
}

TEST(SpeakerDirection, KnowsTheFormOfThePicture) {
  const Box wide = box_of_person(4.0, 1.5, 1.7, 384, 216);
  ASSERT_LT(wide.y_max, 0.995);
  const Spherical found = speaker_direction_from_box(wide, kFov, 384, 216);
  const Spherical truth = spherical_from_cartesian(mouth_of_person(4.0, 1.5, 1.7));
  EXPECT_NEAR(found.distance_m, truth.distance_m, 0.2);  // the body's depth, as above
  // The body's depth again: up to 0.5 degrees, 0.01, off its middle.
  EXPECT_NEAR(found.azimuth_rad, truth.azimuth_rad, 0.02);
}

TEST(SpeakerDirection, AnotherHeightScalesTheDistance) {
  const Box box{0.4, 0.3, 0.6, 0.8};
  const Spherical adult =
      speaker_direction_from_box(box, kFov, 256, 256, {.height_m = 1.8, .mouth_below_top_m = 0});
  const Spherical child =
      speaker_direction_from_box(box, kFov, 256, 256, {.height_m = 0.9, .mouth_below_top_m = 0});
  EXPECT_NEAR(adult.distance_m, 2.0 * child.distance_m, 1e-12);  // rounding
  EXPECT_NEAR(adult.elevation_rad, child.elevation_rad, 1e-12);
}

TEST(SpeakerDirection, CutAtTheBottomTheShouldersTellTheDistance) {
  for (const double x_m : {0.8, 1.0, 1.3}) {
    const Box box = box_of_person(x_m, 0.1, 1.7, 256, 256);
    ASSERT_EQ(box.y_max, 1.0);
    const Spherical found = speaker_direction_from_box(box, kFov, 256, 256);
    const Spherical truth = spherical_from_cartesian(mouth_of_person(x_m, 0.1, 1.7));
    // A round body's front edge looks wider: within 15 % here, where the height alone would put a
    // person of 0.8 m at 1.5 m. At 0.8 m that edge, 0.125 m closer, is seen 0.02 further aside and
    // 0.05 higher.
    EXPECT_NEAR(found.distance_m / truth.distance_m, 1.0, 0.15);
    EXPECT_NEAR(found.azimuth_rad, truth.azimuth_rad, 0.03);
    EXPECT_NEAR(found.elevation_rad, truth.elevation_rad, 0.06);
  }
}

TEST(SpeakerDirection, CutAtTheTopTheMouthIsMeasuredFromTheFeet) {
  // Somebody high on a ladder: 0.3 m of the body is above the picture, the feet are visible.
  const double x_m = 2.0;
  const double rise = 2.1;
  Box box = box_of_person(x_m, -0.3, 1.7, 256, 256);
  box.y_min = 0.0;
  box.y_max -= rise / x_m / 2.0;
  const Spherical found = speaker_direction_from_box(box, kFov, 256, 256);
  const Spherical truth =
      spherical_from_cartesian(mouth_of_person(x_m, -0.3, 1.7) + Vector3{0, 0, rise});
  // Half a body's width, 0.225 m, and a pixel of 256.
  EXPECT_NEAR(found.distance_m, truth.distance_m, 0.25);
  // By 0.25 m of distance the slope to the mouth, 1.52 m above the feet, changes by up to 0.08.
  EXPECT_NEAR(found.elevation_rad, truth.elevation_rad, 0.08);
}

TEST(SpeakerDirection, CutAtTopAndBottomTheMouthIsLevel) {
  const Spherical found = speaker_direction_from_box({0.1, 0.0, 0.9, 1.0}, kFov, 256, 256);
  EXPECT_EQ(found.elevation_rad, 0.0);
  EXPECT_NEAR(found.distance_m, 0.45 / 1.6, 1e-12);  // shoulders over 80 % of a width of 2
}

TEST(SpeakerDirection, CutAtASideTheVisiblePartIsTaken) {
  const Box box = box_of_person(3.0, 2.95, 1.7, 256, 256);
  ASSERT_EQ(box.x_min, 0.0);
  const Spherical found = speaker_direction_from_box(box, kFov, 256, 256);
  // Half a body's width, 0.225 m, and a pixel of 256.
  EXPECT_NEAR(found.distance_m, norm(mouth_of_person(3.0, 2.95, 1.7)), 0.25);
  // At most half a body's width, 0.225 m at 4.2 m, towards the middle.
  EXPECT_NEAR(found.azimuth_rad, std::atan2(2.95, 3.0), 0.06);
}

TEST(SpeakerDirection, RefusesWhatIsNotABox) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Box& box : {Box{0.5, 0.2, 0.5, 0.8}, Box{0.6, 0.2, 0.5, 0.8}, Box{-0.1, 0.2, 0.5, 0.8},
                         Box{0.1, 0.2, 0.5, 1.1}, Box{0.1, nan, 0.5, 0.9}}) {
    EXPECT_THROW(static_cast<void>(speaker_direction_from_box(box, kFov, 256, 256)), InputError);
  }
}

}  // namespace
}  // namespace earpoint

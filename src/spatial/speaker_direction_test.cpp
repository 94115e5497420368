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
constexpr double kHeight_m = 1.7;
constexpr double kMouthHeight_m = kHeight_m - 0.18;
constexpr double kHalfDepth_m = 0.125;  // of a body
constexpr double kHalfWidth_m = 0.225;  // of a body

// The outline below has a point at every degree: its edges are up to half a degree off, by which a
// body looks up to 4e-5 narrower, and at 2 m up to 8e-5 m farther away.
constexpr double kOutline_m = 1e-4;

// The box that a level camera 1.5 m above the floor sees around an upright body: a vertical
// elliptic cylinder, 0.45 m wide and 0.25 m deep, whose feet are at (x, y). Cut at the picture.
Box box_of_person(double x_m, double y_m, int width_px, int height_px) {
  const double half_width = std::tan(kFov / 2);
  const double half_height = half_width * height_px / width_px;
  Box box{1.0, 1.0, 0.0, 0.0};
  for (int step = 0; step < 360; ++step) {
    const double angle = radians_from_degrees(step);
    const double x = x_m + kHalfDepth_m * std::cos(angle);
    const double y = y_m + kHalfWidth_m * std::sin(angle);
    for (const double z : {-kCameraHeight_m, kHeight_m - kCameraHeight_m}) {
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

Vector3 mouth_of_person(double x_m, double y_m) {
  return {x_m, y_m, kMouthHeight_m - kCameraHeight_m};
}

// The tangents from the camera to the outline of a body, y = m x: with a and b half its depth and
// width, (y - m x)^2 = a^2 m^2 + b^2.
struct Outline {
  double middle = 0.0;  // between the two slopes
  double half = 0.0;    // from there to either
};

Outline outline_of(double x_m, double y_m) {
  const double a2 = kHalfDepth_m * kHalfDepth_m;
  const double b2 = kHalfWidth_m * kHalfWidth_m;
  const double scale = x_m * x_m - a2;
  return {x_m * y_m / scale, std::sqrt(x_m * x_m * b2 + y_m * y_m * a2 - a2 * b2) / scale};
}

// A box tells of a flat person. The body's nearest edge makes its top and bottom, so that its
// height puts the person there.
double depth_by_height(double x_m) { return x_m - kHalfDepth_m; }

double depth_by_width(double x_m, double y_m) { return kHalfWidth_m / outline_of(x_m, y_m).half; }

void expect_mouth(const Spherical& found, const Vector3& expected) {
  const Vector3 mouth = cartesian_from_spherical(found);
  EXPECT_NEAR(mouth.x, expected.x, kOutline_m);
  EXPECT_NEAR(mouth.y, expected.y, kOutline_m);
  EXPECT_NEAR(mouth.z, expected.z, kOutline_m);
}

TEST(SpeakerDirection, FindsAPersonWhoIsWhollySeen) {
  for (const double x_m : {2.0, 3.0, 5.0, 8.0}) {
    for (const double lateral : {-0.6, -0.2, 0.0, 0.3, 0.7}) {
      const double y_m = lateral * x_m;
      const Box box = box_of_person(x_m, y_m, 256, 256);
      ASSERT_LT(box.y_max, 0.995);
      const Spherical found = speaker_direction_from_box(box, kFov, 256, 256);
      const double depth_m = depth_by_height(x_m);
      expect_mouth(found, {depth_m, depth_m * outline_of(x_m, y_m).middle,
                           kMouthHeight_m - kCameraHeight_m});
      // In front of the true mouth by half a body's depth, and on the way to it.
      EXPECT_LT(norm(cartesian_from_spherical(found) - mouth_of_person(x_m, y_m)),
                1.01 * std::hypot(1.0, lateral) * kHalfDepth_m);
    }
  }
}

TEST(SpeakerDirection, LeftInThePictureIsPositiveAzimuth) {
  const Spherical found = speaker_direction_from_box({0.1, 0.3, 0.2, 0.8}, kFov, 256, 256);
  EXPECT_GT(found.azimuth_rad, 0.5);
}

TEST(SpeakerDirection, KnowsTheFormOfThePicture) {
  const Box wide = box_of_person(4.0, 1.5, 384, 216);
  ASSERT_LT(wide.y_max, 0.995);
  const double depth_m = depth_by_height(4.0);
  expect_mouth(speaker_direction_from_box(wide, kFov, 384, 216),
               {depth_m, depth_m * outline_of(4.0, 1.5).middle, kMouthHeight_m - kCameraHeight_m});
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
    const Box box = box_of_person(x_m, 0.1, 256, 256);
    ASSERT_EQ(box.y_max, 1.0);
    const Spherical found = speaker_direction_from_box(box, kFov, 256, 256);
    const double depth_m = depth_by_width(x_m, 0.1);
    const double top = (kHeight_m - kCameraHeight_m) / (x_m - kHalfDepth_m);
    expect_mouth(found, {depth_m, depth_m * outline_of(x_m, 0.1).middle,
                         depth_m * top - (kHeight_m - kMouthHeight_m)});
    // The height alone would put a person at 0.8 m at 1.3 m.
    EXPECT_NEAR(depth_m, x_m, 0.02 * x_m) << "a body's front makes it look wider, by up to 1.5 %";
  }
}

TEST(SpeakerDirection, CutAtTheTopTheMouthIsMeasuredFromTheFeet) {
  // Somebody high on a ladder: 0.3 m of the body is above the picture, the feet are visible.
  const double x_m = 2.0;
  const double rise = 2.1;
  Box box = box_of_person(x_m, -0.3, 256, 256);
  box.y_min = 0.0;
  box.y_max -= rise / x_m / 2.0;
  const Spherical found = speaker_direction_from_box(box, kFov, 256, 256);
  const double depth_m = depth_by_width(x_m, -0.3);
  const double feet = rise / x_m - kCameraHeight_m / (x_m - kHalfDepth_m);
  expect_mouth(found,
               {depth_m, depth_m * outline_of(x_m, -0.3).middle, depth_m * feet + kMouthHeight_m});
}

TEST(SpeakerDirection, CutAtTopAndBottomTheMouthIsLevel) {
  const Spherical found = speaker_direction_from_box({0.1, 0.0, 0.9, 1.0}, kFov, 256, 256);
  EXPECT_EQ(found.elevation_rad, 0.0);
  EXPECT_NEAR(found.distance_m, 0.45 / 1.6, 1e-12);  // shoulders over 80 % of a width of 2
}

TEST(SpeakerDirection, CutAtASideTheVisiblePartIsTaken) {
  const Box box = box_of_person(3.0, 2.95, 256, 256);
  ASSERT_EQ(box.x_min, 0.0);
  const Spherical found = speaker_direction_from_box(box, kFov, 256, 256);
  const Outline outline = outline_of(3.0, 2.95);
  const double edge = std::tan(kFov / 2.0);  // of the picture
  const double depth_m = depth_by_height(3.0);
  expect_mouth(found, {depth_m, depth_m * (outline.middle - outline.half + edge) / 2.0,
                       kMouthHeight_m - kCameraHeight_m});
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

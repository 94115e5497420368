#include <earpoint/spatial/speaker_direction.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kEdge = 0.005;  // of the picture's size: detectors rarely end on the last pixel

void check_box(const Box& box) {
  const bool good = box.x_min >= 0.0 && box.x_min < box.x_max && box.x_max <= 1.0 &&
                    box.y_min >= 0.0 && box.y_min < box.y_max && box.y_max <= 1.0;
  if (!good) {
    throw InputError("speaker box",
                     fmt::format("expected 0 <= x_min < x_max <= 1 and the same for y, found x {} "
                                 "to {}, y {} to {}",
                                 box.x_min, box.x_max, box.y_min, box.y_max));
  }
}

}  // namespace

Spherical speaker_direction_from_box(const Box& box, double horizontal_fov_rad, int image_width_px,
                                     int image_height_px, const PersonSize& person) {
  check_box(box);
  EARPOINT_CHECK(horizontal_fov_rad > 0.0 && horizontal_fov_rad < kPi);
  EARPOINT_CHECK(image_width_px > 0 && image_height_px > 0);
  EARPOINT_CHECK(person.height_m > 0.0 && person.width_m > 0.0);

  // Tangents: lateral metres per metre of depth, y to the left and z up from the optical axis.
  const double half_width = std::tan(horizontal_fov_rad / 2.0);
  const double half_height = half_width * image_height_px / image_width_px;
  const double left = half_width * (1.0 - (box.x_min + box.x_max));
  const double top = half_height * (1.0 - 2.0 * box.y_min);
  const double bottom = half_height * (1.0 - 2.0 * box.y_max);
  const double width = 2.0 * half_width * (box.x_max - box.x_min);

  const bool top_cut = box.y_min <= kEdge;
  const bool bottom_cut = box.y_max >= 1.0 - kEdge;
  double depth_m = person.height_m / (top - bottom);
  if (top_cut || bottom_cut) depth_m = std::min(depth_m, person.width_m / width);

  double mouth = top - person.mouth_below_top_m / depth_m;
  if (top_cut) {
    mouth = bottom_cut ? 0.0 : bottom + (person.height_m - person.mouth_below_top_m) / depth_m;
  }
  return spherical_from_cartesian(Vector3{1.0, left, mouth} * depth_m);
}

}  // namespace earpoint

#pragma once

#include <optional>

#include <earpoint/pose.h>

namespace earpoint {

/// A pinhole camera with square pixels. Its frame is the project's: x along the optical axis, y to
/// the left of the picture, z to its top.
struct Camera {
  Pose world_from_camera{};
  double horizontal_fov_rad = kPi / 2.0;  ///< between the left and the right edge; in (0, pi)
  int width = 256;                        ///< pixels, > 0
  int height = 256;                       ///< pixels, > 0
};

/// A place in a picture in pixels: x to the right, y downwards, (0, 0) the top left corner, so that
/// the middle of the first pixel is (0.5, 0.5).
struct PixelPosition {
  double x = 0.0;
  double y = 0.0;
};

/// A rectangle of whole pixels of a picture.
struct PixelRegion {
  int x = 0;  ///< of its left column
  int y = 0;  ///< of its top row
  int width = 0;
  int height = 0;

  friend constexpr bool operator==(const PixelRegion&, const PixelRegion&) = default;
};

/// @throws std::logic_error if a size or the field of view is out of range
void check_camera(const Camera& camera);

/// @return the distance of the picture plane in pixels: width / (2 tan(horizontal_fov_rad / 2))
double focal_length_pixels(const Camera& camera);

/// @return the angle between the top and the bottom edge
double vertical_fov_rad(const Camera& camera);

/// @return the direction towards a place in the picture, in the camera's frame, with x = 1: times
///         the depth it is the point seen there
Vector3 direction_of_pixel(const Camera& camera, PixelPosition pixel);

/// Where a point appears; the place may lie outside the picture.
/// @return nothing for a point that is not in front of the camera
std::optional<PixelPosition> project(const Camera& camera, const Vector3& world_point);

}  // namespace earpoint

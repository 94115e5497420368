#include <earpoint/camera/camera.h>

#include <cmath>

#include <earpoint/error.h>

namespace earpoint {

void check_camera(const Camera& camera) {
  EARPOINT_CHECK(camera.width > 0 && camera.height > 0);
  EARPOINT_CHECK(camera.horizontal_fov_rad > 0.0 && camera.horizontal_fov_rad < kPi);
}

double focal_length_pixels(const Camera& camera) {
  return camera.width / (2.0 * std::tan(camera.horizontal_fov_rad / 2.0));
}

double vertical_fov_rad(const Camera& camera) {
  return 2.0 * std::atan(camera.height / (2.0 * focal_length_pixels(camera)));
}

Vector3 direction_of_pixel(const Camera& camera, PixelPosition pixel) {
  const double focal = focal_length_pixels(camera);
  return {1.0, (camera.width / 2.0 - pixel.x) / focal, (camera.height / 2.0 - pixel.y) / focal};
}

std::optional<PixelPosition> project(const Camera& camera, const Vector3& world_point) {
  const Vector3 point = transform_point(inverse(camera.world_from_camera), world_point);
  if (point.x <= 0.0) return std::nullopt;
  const double focal = focal_length_pixels(camera);
  return PixelPosition{camera.width / 2.0 - focal * point.y / point.x,
                       camera.height / 2.0 - focal * point.z / point.x};
}

}  // namespace earpoint

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/scene/mesh.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// The planes of a mesh's triangles, to find where a ray meets one exactly as on any other machine:
/// a ray tracing library computes distances by reciprocals that differ from processor to processor
/// in the last bits, and every reflection of a path makes the difference larger.
class TrianglePlanes {
 public:
  TrianglePlanes() = default;
  explicit TrianglePlanes(const Mesh& mesh);

  /// How far along a ray that meets a triangle it meets the triangle's plane.
  /// @param triangle   index into the mesh
  /// @param direction  of any length; the distance is in units of it
  /// @return >= 0; near enough to the triangle's middle to be in it, also where the ray grazes the
  ///         plane or the triangle is degenerate, so that the plane does not tell
  [[nodiscard]] float distance(std::size_t triangle, const std::array<float, 3>& origin,
                               const std::array<float, 3>& direction) const {
    const Plane& plane = planes_[triangle];
    const double slope = along(plane.normal, direction);
    double squared = 0.0;
    for (const float x : direction) squared += double{x} * x;
    constexpr double kGrazing = 1e-3;
    if (slope * slope > kGrazing * kGrazing * squared) {
      return static_cast<float>((plane.offset - along(plane.normal, origin)) / slope);
    }
    const double middle = (along(plane.middle, direction) - along_ray(origin, direction)) / squared;
    const double reach = plane.radius_m / std::sqrt(squared);
    // Not a number without a slope: then the middle has to do.
    const double met = (plane.offset - along(plane.normal, origin)) / slope;
    const double within =
        std::isfinite(met) ? std::clamp(met, middle - reach, middle + reach) : middle;
    return static_cast<float>(std::max(0.0, within));
  }

 private:
  struct Plane {
    std::array<double, 3> normal{};  // unit length; zero where the triangle has no area
    double offset = 0.0;
    std::array<double, 3> middle{};  // of the corners
    double radius_m = 0.0;           // around it, to the farthest corner
  };

  static double along(const std::array<double, 3>& a, const std::array<float, 3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
  static double along_ray(const std::array<float, 3>& origin,
                          const std::array<float, 3>& direction) {
    return along({origin[0], origin[1], origin[2]}, direction);
  }

  std::vector<Plane> planes_;
};

}  // namespace earpoint

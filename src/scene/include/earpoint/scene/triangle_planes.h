#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/core/vector3.h>
#include <earpoint/scene/mesh.h>

namespace earpoint {

/// The planes of a mesh's triangles, to find where a ray meets one exactly as on any other machine:
/// a ray tracing library computes distances by reciprocals that differ from processor to processor
/// in the last bits, and a path that is reflected again and again makes the most of them.
class TrianglePlanes {
 public:
  TrianglePlanes() = default;
  explicit TrianglePlanes(const Mesh& mesh);

  /// How far along the ray the triangle's plane is met.
  /// @param triangle   index into the mesh
  /// @param direction  of any length; the distance is in units of it
  /// @param estimate   what was found by other means; returned as it is where the ray grazes the
  ///                   plane or the triangle is degenerate, so that the plane does not tell
  [[nodiscard]] float distance(std::size_t triangle, const std::array<float, 3>& origin,
                               const std::array<float, 3>& direction, float estimate) const {
    const Plane& plane = planes_[triangle];
    const double slope = along(plane, direction);
    double squared = 0.0;
    for (const float x : direction) squared += double{x} * x;
    // Nearer to the plane than that, single precision does not tell where it is met.
    constexpr double kGrazing = 1e-4;
    if (slope * slope <= kGrazing * kGrazing * squared) return estimate;
    return static_cast<float>((plane.offset - along(plane, origin)) / slope);
  }

 private:
  struct Plane {
    std::array<double, 3> normal{};  // unit length; zero where the triangle has no area
    double offset = 0.0;
  };

  static double along(const Plane& plane, const std::array<float, 3>& v) {
    return plane.normal[0] * v[0] + plane.normal[1] * v[1] + plane.normal[2] * v[2];
  }

  std::vector<Plane> planes_;
};

}  // namespace earpoint

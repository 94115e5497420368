#include "escape_check.h"

#include "sphere_points.h"

#include <cmath>
#include <limits>
#include <optional>

#include <fmt/core.h>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kProbes = 400;

// Whether a surface passes through the place, to within a millimetre. Rays begin a centimetre
// before it, so that none starts on the surface itself.
bool lies_on_surface(const SceneGeometry& scene, const Vector3& place) {
  constexpr double kReach_m = 0.01;
  constexpr double kOn_m = 1e-3;
  for (int i = 0; i < kProbes; ++i) {
    const Vector3 direction = spiral_direction(i, 0.5, kProbes, 0.0);
    const std::optional<TriangleHit> hit = scene.rays().closest(
        place - direction * kReach_m, direction, 2.0 * kReach_m, SceneGeometry::still_layers());
    if (!hit) continue;
    const BounceFacet& facet = scene.facet(hit->triangle);
    if (std::abs(dot(facet.exact_normal, place) - facet.offset_m) < kOn_m) return true;
  }
  return false;
}

// The share of horizontal directions without any surface. In a room without a ceiling it is zero
// everywhere; outside of the walls it is half or more.
double open_level_share(const SceneGeometry& scene, const Vector3& place) {
  constexpr int kDirections = 90;
  constexpr double kDown = -0.02;  // off the walls' upper edges
  int open = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double azimuth_rad = 2.0 * kPi * i / kDirections;
    const Vector3 direction =
        normalized(Vector3{std::cos(azimuth_rad), std::sin(azimuth_rad), kDown});
    constexpr double kFar_m = std::numeric_limits<float>::max();
    if (!scene.rays().closest(place, direction, kFar_m, SceneGeometry::still_layers())) ++open;
  }
  return static_cast<double>(open) / kDirections;
}

}  // namespace

void check_escape(const SceneGeometry& scene, const Vector3& source_m, double fraction,
                  double limit) {
  if (fraction <= limit) return;
  if (lies_on_surface(scene, source_m)) {
    throw InputError(
        "the source",
        fmt::format("is on a surface: {:.0f} % of its rays are lost behind it", 100.0 * fraction),
        "move it 1 cm or more into the room");
  }
  constexpr double kOutside = 0.4;
  if (open_level_share(scene, source_m) > kOutside) {
    throw InputError(
        "the source",
        fmt::format("is outside the walls: {:.0f} % of its rays hit no surface", 100.0 * fraction),
        "place it in a closed room");
  }
  throw InputError("the mesh",
                   fmt::format("leaks: {:.1f} % of the sound escapes through holes, expected at "
                               "most {:.1f} %",
                               100.0 * fraction, 100.0 * limit),
                   "close the holes; a missing ceiling can be added (close the ceiling)");
}

}  // namespace earpoint

#include "camera_ring.h"

#include <algorithm>
#include <cmath>

namespace earpoint {
namespace {

constexpr int kCentres = 300;
constexpr double kCentreClearance_m = 0.5;
constexpr double kTripod_m = 0.2;
constexpr double kNearest_m = 1.2;
constexpr double kFarthest_m = 3.2;
constexpr double kStep_m = 0.1;
constexpr double kHeight_m = 1.5;
constexpr double kLookAt_m = 1.25;
// Random share of the angle between two cameras.
constexpr double kLooseness = 0.25;

/// @return the farthest place in this direction at which a camera can stand
std::optional<FloorPoint> farthest_place(const PreparedScene& scene, const FloorPoint& centre,
                                         double angle_rad) {
  for (double radius_m = kFarthest_m; radius_m >= kNearest_m; radius_m -= kStep_m) {
    const FloorPoint at{centre.x + radius_m * std::cos(angle_rad),
                        centre.y + radius_m * std::sin(angle_rad)};
    if (scene.floor.clearance_m(at) < kTripod_m) continue;
    const Vector3 eye{at.x, at.y, kHeight_m};
    if (sees(scene.caster, eye, {centre.x, centre.y, kHeight_m}) &&
        sees(scene.caster, eye, {centre.x, centre.y, 1.0})) {
      return at;
    }
  }
  return std::nullopt;
}

std::optional<CameraRing> ring_around(const PreparedScene& scene, const FloorPoint& centre,
                                      int cameras, RandomStream& random) {
  CameraRing ring{.centre = centre, .least_radius_m = kFarthest_m, .world_from_camera = {}};
  const double between_rad = 2.0 * kPi / cameras;
  const double first_rad = random.uniform(0.0, between_rad);
  for (int i = 0; i < cameras; ++i) {
    const double aside = random.uniform(-kLooseness, kLooseness);
    const auto at = farthest_place(scene, centre, first_rad + (i + aside) * between_rad);
    if (!at) return std::nullopt;
    ring.least_radius_m = std::min(ring.least_radius_m, distance_m(*at, centre));
    ring.world_from_camera.push_back(
        look_at({at->x, at->y, kHeight_m}, {centre.x, centre.y, kLookAt_m}));
  }
  return ring;
}

}  // namespace

std::optional<CameraRing> place_cameras(const PreparedScene& scene, int cameras,
                                        RandomStream& random) {
  std::optional<CameraRing> best;
  for (int i = 0; i < kCentres; ++i) {
    const auto centre = scene.floor.draw(kCentreClearance_m, random);
    if (!centre) return std::nullopt;
    auto ring = ring_around(scene, *centre, cameras, random);
    if (ring && (!best || ring->least_radius_m > best->least_radius_m)) best = std::move(ring);
  }
  return best;
}

}  // namespace earpoint

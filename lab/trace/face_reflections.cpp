#include "face_reflections.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace earpoint {
namespace {

// A place over a face, seen from its first edge.
struct OverFace {
  double across_m = 0.0;  // towards the second edge
  double height_m = 0.0;
  double z_m = 0.0;
};

OverFace over_face(const SceneGeometry& scene, const EdgePair& pair, const Vector3& place) {
  const EdgePoint point = edge_point(scene.edges()[pair.edges[0]], place);
  const double angle_rad = std::abs(point.angle_rad - pair.face_angle_rad[0]);
  return {point.radius_m * std::cos(angle_rad), point.radius_m * std::sin(angle_rad), point.z_m};
}

// The point at which the face mirrors one place to another.
std::optional<Vector3> mirror_point(const SceneGeometry& scene, const EdgePair& pair,
                                    const OverFace& here, const OverFace& there) {
  if (here.height_m <= 0.0 || there.height_m <= 0.0) return std::nullopt;
  const double share = here.height_m / (here.height_m + there.height_m);
  const double across_m = here.across_m + share * (there.across_m - here.across_m);
  if (across_m <= 0.0 || across_m >= pair.face.width_m) return std::nullopt;
  const double z = here.z_m + share * (there.z_m - here.z_m);
  const double opposite_z = pair.opposite_z(0, z);
  const DiffractionEdge& first = scene.edges()[pair.edges[0]];
  const DiffractionEdge& second = scene.edges()[pair.edges[1]];
  if (z < 0.0 || z > first.length_m || opposite_z < 0.0 || opposite_z > second.length_m) {
    return std::nullopt;
  }
  const Vector3 start = point_on_edge(first, z, 0.0);
  const Vector3 end = point_on_edge(second, opposite_z, 0.0);
  return start + (end - start) * (across_m / pair.face.width_m);
}

}  // namespace

std::vector<Arrival> face_reflections(const SceneGeometry& scene, const Source& source,
                                      const EdgeView& from, const EdgeView& to,
                                      std::span<const Arrival> others,
                                      const Propagation& propagation) {
  std::vector<Arrival> arrivals;
  for (const EdgePair& pair : scene.edge_pairs()) {
    const OverFace here = over_face(scene, pair, from.place());
    const OverFace there = over_face(scene, pair, to.place());
    const std::optional<Vector3> point = mirror_point(scene, pair, here, there);
    if (!point) continue;
    const double distance_m = norm(Vector3{here.across_m - there.across_m,
                                           here.height_m + there.height_m, here.z_m - there.z_m});
    if (is_mirrored(others, distance_m, propagation.speed_m_per_s)) continue;
    const BounceFacet& facet = scene.facet(pair.face_triangle);
    const double side = dot(facet.exact_normal, from.place()) > facet.offset_m ? 1.0 : -1.0;
    const Vector3 above = *point + facet.exact_normal * (side * scene.surface_offset_m());
    if (scene.rays().occluded(from.place(), above, scene.mask_without(source.body))) continue;
    if (scene.rays().occluded(above, to.place(), kAllLayers)) continue;

    const Vector3 departure = normalized(*point - from.place());
    BandArray energy = sent_energy(source, departure);
    for (int band = 0; band < kOctaveBands; ++band) {
      energy[band] *= scene.surface(facet).specular[band];
    }
    const Vector3 image = to.place() + normalized(*point - to.place()) * distance_m;
    arrivals.push_back(make_arrival(propagation, to.place(), image, departure, energy));
    arrivals.back().order = 1;
  }
  return arrivals;
}

bool is_mirrored(std::span<const Arrival> arrivals, double distance_m, double speed_m_per_s) {
  constexpr double kSameWay_m = 1e-3;
  return std::any_of(arrivals.begin(), arrivals.end(), [&](const Arrival& arrival) {
    return arrival.order > 0 && std::abs(arrival.delay_s * speed_m_per_s - distance_m) < kSameWay_m;
  });
}

}  // namespace earpoint

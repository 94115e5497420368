#include "passages.h"

#include "scene_geometry.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kNarrowest_m = 0.2;
constexpr double kWidest_m = 3.0;
constexpr double kOff_m = 0.02;  // tolerated deviation from a rectangle
constexpr double kRight_rad = 0.1;

bool is_right_angled(const EdgePair& pair) {
  return std::all_of(pair.face.open_angle_rad.begin(), pair.face.open_angle_rad.end(),
                     [](double open_rad) { return std::abs(open_rad - 1.5 * kPi) < kRight_rad; });
}

// Middle of the part in which both faces overlap, along the first edge of the first face.
std::optional<double> shared_middle_m(std::span<const DiffractionEdge> edges, const EdgePair& first,
                                      const EdgePair& second) {
  const DiffractionEdge& along = edges[first.edges[0]];
  const DiffractionEdge& other = edges[second.edges[0]];
  const double a = edge_point(along, other.origin_m).z_m;
  const double b = edge_point(along, point_on_edge(other, other.length_m, 0.0)).z_m;
  const double begin_m = std::max(0.0, std::min(a, b));
  const double end_m = std::min(along.length_m, std::max(a, b));
  if (end_m - begin_m < kNarrowest_m) return std::nullopt;
  return (begin_m + end_m) / 2.0;
}

std::optional<FacingPair> face_up(const SceneGeometry& scene,
                                  std::span<const DiffractionEdge> edges,
                                  std::span<const EdgePair> pairs, std::size_t i, std::size_t j) {
  constexpr double kParallel = 0.9995;
  const EdgePair& first = pairs[i];
  const EdgePair& second = pairs[j];
  const DiffractionEdge& origin = edges[first.edges[0]];
  if (std::abs(dot(origin.direction, edges[second.edges[0]].direction)) < kParallel) {
    return std::nullopt;
  }
  if (!is_right_angled(first) || !is_right_angled(second)) return std::nullopt;
  FacingPair facing;
  facing.faces = {i, j};
  facing.edges[0] = first.edges;
  facing.origin_m = origin.origin_m;
  facing.along = origin.direction;
  const DiffractionEdge& far = edges[first.edges[1]];
  const Vector3 across = far.origin_m - origin.origin_m;
  facing.through = normalized(across - origin.direction * dot(across, origin.direction));
  facing.over = cross(origin.direction, facing.through);
  // Points into the air over the face.
  if (dot(facing.over, point_on_edge(origin, 0.0, 1.0) - origin.origin_m) < 0.0) {
    facing.over = -facing.over;
  }
  facing.passage.depth_m = first.face.width_m;
  facing.passage.width_m = facing.place(edges[second.edges[0]].origin_m).y_m;
  if (facing.passage.width_m < kNarrowest_m || facing.passage.width_m > kWidest_m) {
    return std::nullopt;
  }
  // The edges of the second face must be opposite those of the first, with its air on this side.
  const DiffractionEdge& opposite = edges[second.edges[0]];
  const Vector3 into_air = point_on_edge(opposite, 0.0, 1.0) - opposite.origin_m;
  if (dot(facing.over, into_air) > 0.0) return std::nullopt;
  facing.edges[1] = second.edges;
  if (facing.place(edges[second.edges[0]].origin_m).x_m > facing.passage.depth_m / 2.0) {
    std::swap(facing.edges[1][0], facing.edges[1][1]);
  }
  for (int end = 0; end < 2; ++end) {
    const PassagePlace place = facing.place(edges[facing.edges[1][end]].origin_m);
    const double off_m = std::abs(place.x_m - (end == 0 ? 0.0 : facing.passage.depth_m));
    if (off_m > kOff_m || std::abs(place.y_m - facing.passage.width_m) > kOff_m) {
      return std::nullopt;
    }
  }
  const std::optional<double> middle_m = shared_middle_m(edges, first, second);
  if (!middle_m) return std::nullopt;
  const Vector3 on_face = point_on_edge(origin, *middle_m, 0.0) +
                          facing.through * (facing.passage.depth_m / 2.0) +
                          facing.over * scene.surface_offset_m();
  const Vector3 on_other =
      on_face + facing.over * (facing.passage.width_m - 2.0 * scene.surface_offset_m());
  if (scene.rays().occluded(on_face, on_other, scene.still_layers())) return std::nullopt;
  return facing;
}

}  // namespace

std::vector<FacingPair> find_facing_pairs(const SceneGeometry& scene,
                                          std::span<const DiffractionEdge> edges,
                                          std::span<const EdgePair> pairs) {
  std::vector<FacingPair> found;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (std::size_t j = i + 1; j < pairs.size(); ++j) {
      if (const std::optional<FacingPair> facing = face_up(scene, edges, pairs, i, j)) {
        found.push_back(*facing);
      }
    }
  }
  return found;
}

}  // namespace earpoint

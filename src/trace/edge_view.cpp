#include "edge_view.h"

#include <algorithm>
#include <cmath>

#include <earpoint/core/pose.h>

namespace earpoint {
namespace {

constexpr double kStretch_m = 0.25;    // an edge is in sight or not in stretches of this length
constexpr double kClearance_m = 5e-3;  // how far from the edge its stretches are looked at

std::size_t stretch_count(const DiffractionEdge& edge) {
  return static_cast<std::size_t>(std::max(1L, std::lround(edge.length_m / kStretch_m)));
}

bool is_in_air(const DiffractionEdge& edge, const EdgePoint& point) {
  return point.radius_m > kClearance_m &&
         point.angle_rad < edge.wedge.open_angle_rad + kOnBoundary_rad;
}

}  // namespace

EdgeView::EdgeView(const SceneGeometry& scene, const Vector3& place, LayerMask mask,
                   std::int64_t& rays_cast)
    : scene_(&scene), place_(place) {
  for (const DiffractionEdge& edge : scene.edges()) {
    std::vector<bool>& stretches = in_sight_.emplace_back(stretch_count(edge), false);
    // From inside the wedge's solid no stretch is in sight.
    if (!is_in_air(edge, edge_point(edge, place))) continue;
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      const double z_m =
          (static_cast<double>(i) + 0.5) * edge.length_m / static_cast<double>(stretches.size());
      ++rays_cast;
      stretches[i] = !scene.rays().occluded(place, point_on_edge(edge, z_m, kClearance_m), mask);
    }
  }
  for (const EdgePair& pair : scene.edge_pairs()) {
    hide_behind(pair, 0);
    hide_behind(pair, 1);
  }
}

// The rays end a little off the edge, and see it from a little behind the face that hides it.
void EdgeView::hide_behind(const EdgePair& pair, int nearer) {
  const DiffractionEdge& hiding = scene_->edges()[pair.edges[nearer]];
  const EdgePoint point = edge_point(hiding, place_);
  if (!is_in_air(hiding, point)) return;
  const double from_face_rad = std::abs(point.angle_rad - pair.face_angle_rad[nearer]);
  if (from_face_rad <= kPi + kOnBoundary_rad) return;
  const std::size_t edge = pair.edges[1 - nearer];
  std::vector<bool>& stretches = in_sight_[edge];
  const double step_m = scene_->edges()[edge].length_m / static_cast<double>(stretches.size());
  const double a = pair.first_z(nearer, 0.0);
  const double b = pair.first_z(nearer, hiding.length_m);
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const double z = pair.first_z(1 - nearer, (static_cast<double>(i) + 0.5) * step_m);
    if (z > std::min(a, b) && z < std::max(a, b)) stretches[i] = false;
  }
}

bool EdgeView::sees(std::size_t edge) const {
  const std::vector<bool>& stretches = in_sight_[edge];
  return std::find(stretches.begin(), stretches.end(), true) != stretches.end();
}

std::vector<EdgeInterval> EdgeView::join(std::size_t edge,
                                         const std::vector<bool>& in_sight) const {
  const double step_m = scene_->edges()[edge].length_m / static_cast<double>(in_sight.size());
  std::vector<EdgeInterval> intervals;
  for (std::size_t i = 0; i < in_sight.size(); ++i) {
    if (!in_sight[i]) continue;
    const double end_m = static_cast<double>(i + 1) * step_m;
    if (i > 0 && in_sight[i - 1]) {
      intervals.back().end_m = end_m;
    } else {
      intervals.push_back({static_cast<double>(i) * step_m, end_m});
    }
  }
  return intervals;
}

std::vector<EdgeInterval> EdgeView::intervals(std::size_t edge) const {
  return join(edge, in_sight_[edge]);
}

std::vector<EdgeInterval> EdgeView::in_sight_of_both(const EdgeView& a, const EdgeView& b,
                                                     std::size_t edge) {
  std::vector<bool> both = a.in_sight_[edge];
  for (std::size_t i = 0; i < both.size(); ++i) both[i] = both[i] && b.in_sight_[edge][i];
  return a.join(edge, both);
}

}  // namespace earpoint

#include "edge_view.h"

#include <algorithm>
#include <cmath>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kStretch_m = 0.25;  // things that hide less of an edge may be missed
constexpr double kEnd_m = 2e-3;      // also tested at this distance from either end
constexpr double kBorder_m = 2e-4;   // accuracy of the ends of visible parts

bool is_in_air(const DiffractionEdge& edge, const EdgePoint& point) {
  return point.radius_m > kEdgeClearance_m &&
         point.angle_rad < edge.wedge.open_angle_rad + kOnBoundary_rad;
}

// Finds the parts of one edge that are visible from one place.
class EdgeLook {
 public:
  EdgeLook(const SceneGeometry& scene, const DiffractionEdge& edge, const Vector3& place,
           LayerMask mask, std::int64_t& rays_cast)
      : scene_(scene), edge_(edge), place_(place), mask_(mask), rays_cast_(rays_cast) {}

  [[nodiscard]] std::vector<EdgeInterval> intervals() const {
    const int count = std::max(1, static_cast<int>(std::lround(edge_.length_m / kStretch_m)));
    std::vector<EdgeInterval> intervals;
    double last_z = 0.0;
    bool last_sees = false;
    for (int i = -1; i <= count; ++i) {
      // Close to either end, and in the middles of stretches between.
      const double z =
          i < 0 ? kEnd_m : std::min(edge_.length_m - kEnd_m, (i + 0.5) * edge_.length_m / count);
      const bool sees_now = sees(z);
      if (sees_now && !last_sees) {
        intervals.push_back({i < 0 ? 0.0 : border(last_z, z), edge_.length_m});
      } else if (!sees_now && last_sees) {
        intervals.back().end_m = border(z, last_z);
      }
      last_z = z;
      last_sees = sees_now;
    }
    return intervals;
  }

 private:
  [[nodiscard]] bool sees(double z) const {
    ++rays_cast_;
    return !scene_.rays().occluded(place_, point_on_edge(edge_, z, kEdgeClearance_m), mask_);
  }

  // The border between a hidden and a visible place.
  [[nodiscard]] double border(double hidden_z, double seen_z) const {
    while (std::abs(hidden_z - seen_z) > kBorder_m) {
      const double middle = (hidden_z + seen_z) / 2.0;
      (sees(middle) ? seen_z : hidden_z) = middle;
    }
    return (hidden_z + seen_z) / 2.0;
  }

  const SceneGeometry& scene_;
  const DiffractionEdge& edge_;
  const Vector3& place_;
  LayerMask mask_;
  std::int64_t& rays_cast_;
};

// The intervals without another interval.
std::vector<EdgeInterval> without(const std::vector<EdgeInterval>& intervals,
                                  const EdgeInterval& hole) {
  std::vector<EdgeInterval> left;
  for (const EdgeInterval& interval : intervals) {
    const EdgeInterval before{interval.begin_m, std::min(interval.end_m, hole.begin_m)};
    const EdgeInterval after{std::max(interval.begin_m, hole.end_m), interval.end_m};
    if (before.begin_m < before.end_m) left.push_back(before);
    if (after.begin_m < after.end_m) left.push_back(after);
  }
  return left;
}

}  // namespace

EdgeView::EdgeView(const SceneGeometry& scene, const Vector3& place, LayerMask mask,
                   std::int64_t& rays_cast)
    : place_(place), in_sight_(scene.edges().size()) {
  for (std::size_t i = 0; i < in_sight_.size(); ++i) {
    const DiffractionEdge& edge = scene.edges()[i];
    // From inside the wedge's solid nothing is visible.
    if (!is_in_air(edge, edge_point(edge, place))) continue;
    in_sight_[i] = EdgeLook(scene, edge, place, mask, rays_cast).intervals();
  }
  for (const EdgePair& pair : scene.edge_pairs()) {
    hide_behind(scene, pair, 0);
    hide_behind(scene, pair, 1);
  }
}

// Rays end a little off the edge and so reach it from slightly behind the face that hides it.
void EdgeView::hide_behind(const SceneGeometry& scene, const EdgePair& pair, int nearer) {
  const DiffractionEdge& hiding = scene.edges()[pair.edges[nearer]];
  const EdgePoint point = edge_point(hiding, place_);
  if (!is_in_air(hiding, point)) return;
  const double from_face_rad = std::abs(point.angle_rad - pair.face_angle_rad[nearer]);
  if (from_face_rad <= kPi + kOnBoundary_rad) return;
  const double a = pair.opposite_z(nearer, 0.0);
  const double b = pair.opposite_z(nearer, hiding.length_m);
  std::vector<EdgeInterval>& hidden = in_sight_[pair.edges[1 - nearer]];
  hidden = without(hidden, {std::min(a, b), std::max(a, b)});
}

}  // namespace earpoint

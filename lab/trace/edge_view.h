#pragma once

#include "scene_geometry.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace earpoint {

/// How far from an edge it is looked for, into the middle of its air.
constexpr double kEdgeClearance_m = 5e-3;

/// Which parts of the scene's edges can be seen from a place.
class EdgeView {
 public:
  /// @param mask       layers that are in the way
  /// @param rays_cast  counts on
  EdgeView(const SceneGeometry& scene, const Vector3& place, LayerMask mask,
           std::int64_t& rays_cast);

  [[nodiscard]] const Vector3& place() const { return place_; }

  /// @return whether any part of an edge is in sight
  [[nodiscard]] bool sees(std::size_t edge) const { return !in_sight_[edge].empty(); }

  /// @return the parts in sight, in ascending order
  [[nodiscard]] const std::vector<EdgeInterval>& intervals(std::size_t edge) const {
    return in_sight_[edge];
  }

 private:
  void hide_behind(const SceneGeometry& scene, const EdgePair& pair, int nearer);

  Vector3 place_;
  std::vector<std::vector<EdgeInterval>> in_sight_;  // [edge]
};

}  // namespace earpoint

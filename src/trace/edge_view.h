#pragma once

#include "scene_geometry.h"

#include <cstdint>
#include <vector>

namespace earpoint {

/// Which stretches of the scene's edges can be seen from a place.
class EdgeView {
 public:
  /// @param mask       layers that are in the way
  /// @param rays_cast  counts on
  EdgeView(const SceneGeometry& scene, const Vector3& place, LayerMask mask,
           std::int64_t& rays_cast);

  [[nodiscard]] const Vector3& place() const { return place_; }

  /// @return whether any stretch of an edge is in sight
  [[nodiscard]] bool sees(std::size_t edge) const;

  /// @return the stretches in sight, in ascending order; neighbours joined
  [[nodiscard]] std::vector<EdgeInterval> intervals(std::size_t edge) const;

  /// @return the stretches in sight of both places
  static std::vector<EdgeInterval> in_sight_of_both(const EdgeView& a, const EdgeView& b,
                                                    std::size_t edge);

 private:
  void hide_behind(const EdgePair& pair, int nearer);
  std::vector<EdgeInterval> join(std::size_t edge, const std::vector<bool>& in_sight) const;

  const SceneGeometry* scene_;
  Vector3 place_;
  std::vector<std::vector<bool>> in_sight_;  // [edge][stretch]
};

}  // namespace earpoint

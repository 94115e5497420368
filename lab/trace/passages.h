#pragma once

#include "diffraction_edges.h"
#include "passage_sound.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/vector3.h>

namespace earpoint {

class SceneGeometry;

/// Two faces that look at each other across an opening in a flat wall: the sides of a door.
struct FacingPair {
  std::array<std::size_t, 2> faces{};  ///< indices of edge pairs
  /// Indices of edges [face][where x = 0, or at the passage's depth].
  std::array<std::array<std::size_t, 2>, 2> edges{};
  Passage passage;
  /// The passage's coordinates: x through the wall, y from the first face to the second, origin on
  /// an edge of the first face.
  Vector3 origin_m;
  Vector3 through;
  Vector3 over;
  Vector3 along;  ///< unit vector along the edges

  /// @return a place in the passage's coordinates
  [[nodiscard]] PassagePlace place(const Vector3& point) const {
    return {dot(point - origin_m, through), dot(point - origin_m, over)};
  }
};

/// Finds what sound passes as it passes a slit in a wall: edges of right angles, four in a
/// rectangle, with nothing in between, 0.2 to 3 m apart.
std::vector<FacingPair> find_facing_pairs(const SceneGeometry& scene,
                                          std::span<const DiffractionEdge> edges,
                                          std::span<const EdgePair> pairs);

}  // namespace earpoint

#pragma once

#include "edge_view.h"
#include "passages.h"
#include "scene_geometry.h"

#include <array>
#include <optional>
#include <vector>

namespace earpoint {

/// A way that sound takes.
struct Way {
  double distance_m = 0.0;
  Vector3 leaves_to;
  Vector3 comes_from;
};

/// The path of sound that meets both sides of a passage.
struct PassageWay {
  Passage passage;
  PassagePlace before;
  PassagePlace behind;
  /// Through from one side to the other, at right angles to the edges: to the side in the
  /// passage's front, and on from there.
  struct Crossing {
    double in_m = 0.0;
    double out_m = 0.0;
    double apex_z_m = 0.0;
    std::vector<EdgeInterval> in_sight;  ///< from both ends
  };
  std::array<Crossing, 2> crossings;  ///< [side that it comes in by]
  BandArray counts{};     ///< weight per band: reflections of both sides, less close to the wall
  double across_m = 0.0;  ///< of the shorter crossing
  Way shortest;
};

/// @return nothing if both places are on one side of the wall, or do not see into the passage
std::optional<PassageWay> way_through(const SceneGeometry& scene, const FacingPair& facing,
                                      const EdgeView& from, const EdgeView& to);

/// What the passage sends, but for what either side sends alone: what goes to and fro between both.
/// It is known for a line source and endless edges. For a point source the spreading of the
/// unfolded way takes the place of the line's; edges of finite length count by the Fresnel integral
/// over what is in sight of them.
/// @return  pressure relative to 1 m in free field; its phase is relative to the shortest way's
DiffractionSpectrum sound_of_both_sides(const PassageWay& way, double speed_m_per_s);

}  // namespace earpoint

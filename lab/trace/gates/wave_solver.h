#pragma once

#include <array>
#include <span>
#include <vector>

namespace earpoint::gates {

/// A point of a plane, metres.
struct PlanePoint {
  double x = 0.0;
  double y = 0.0;
};

/// A rigid rectangle of the plane. Sides that lie far outside of what is solved may be given as far
/// as one likes.
struct PlaneBlock {
  PlanePoint low;
  PlanePoint high;
};

/// Octaves that the wave solver gives levels for.
constexpr std::array<double, 3> kSolvedOctavesHz = {125.0, 250.0, 500.0};
using SolvedLevels = std::array<double, kSolvedOctavesHz.size()>;

/// The sound of a point source among rigid blocks that are endless across the plane, by finite
/// differences of the wave equation in the plane (leapfrog of pressure and velocity on a staggered
/// grid; Botteldooren, JASA 98, 1995), with layers around that swallow what leaves, and an integral
/// over the wave number across the plane. Knows nothing of edges or rays.
///
/// Levels are relative to the same source in free field at the same place, on the same grid.
/// @param step_m  of the grid; all sides of blocks must be its multiples
/// @return  [listeners], dB, each the energy of white sound in an octave, as `band_of` filters it
std::vector<SolvedLevels> solve_waves(std::span<const PlaneBlock> blocks, const PlanePoint& source,
                                      std::span<const PlanePoint> listeners, double step_m,
                                      double speed_m_per_s);

}  // namespace earpoint::gates

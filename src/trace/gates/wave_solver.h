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

/// The sound of a line source among rigid blocks, by finite differences of the wave equation in the
/// plane (leapfrog of pressure and velocity on a staggered grid; Botteldooren, JASA 98, 1995), with
/// layers around that swallow what leaves. Knows nothing of edges or rays.
///
/// Levels are relative to the same source in free field at the same place, on the same grid. So
/// relative, they hold for a point source too, as long as its ways lie in the plane and are long
/// against a wave: both spread over the same lengths.
/// @param step_m  of the grid; all sides of blocks must be its multiples
/// @return  [listeners], dB, each the mean energy of an octave of white sound
std::vector<SolvedLevels> solve_waves(std::span<const PlaneBlock> blocks, const PlanePoint& source,
                                      std::span<const PlanePoint> listeners, double step_m,
                                      double speed_m_per_s);

}  // namespace earpoint::gates

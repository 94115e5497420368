#pragma once

#include <complex>

namespace earpoint {

/// A passage through a wall, cut across: the wall lies along y, from x = 0 to `depth_m`, and is
/// open from y = 0 to `width_m`. All is rigid and endless along z.
struct Passage {
  double width_m = 0.0;  ///< > 0
  double depth_m = 0.0;  ///< > 0
};

/// A place in front of the passage or behind it.
struct PassagePlace {
  double x_m = 0.0;
  double y_m = 0.0;
};

/// All sound that passes, of a line source that makes H0(2) in free field: modes across the passage
/// are matched, at both ends, to the sound of a half-space with a rigid wall (as for slits in
/// Mechel, Formulas of Acoustics, 2008). Exact but for the number of modes, for places 0.2 m off
/// the passage.
/// @param source    x < 0
/// @param receiver  x > depth
std::complex<double> sound_through_passage(const Passage& passage, const PassagePlace& source,
                                           const PassagePlace& receiver, double wave_number);

/// The same, with each side of the passage alone in the way: straight sound, reflections and all
/// orders of diffraction of either side, but nothing that meets both sides.
std::complex<double> sound_past_single_sides(const Passage& passage, const PassagePlace& source,
                                             const PassagePlace& receiver, double wave_number);

}  // namespace earpoint

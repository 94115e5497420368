#pragma once

#include "wedge_diffraction.h"

#include <span>
#include <vector>

#include <earpoint/core/octave_bands.h>
#include <earpoint/spatial/arrival.h>

namespace earpoint {

/// Sound that came one way round edges.
struct BentWave {
  double distance_m = 0.0;
  DiffractionSpectrum spectrum{};  ///< its phase is relative to that of a way of `distance_m`
  BandArray weight = all_bands(1.0F);  ///< of the source's directivity and the air
};

/// Arrivals have a real gain per band, diffracted waves a phase: gains that make the sum of all
/// arrivals as loud as the sum of all waves. Each wave gets the root of its energy, with the sign of
/// its real part, and all are then scaled together, band by band. The energy of a sum is the mean
/// over the octave, with every wave as it is at the band's centre.
/// @param others  what has arrived without a bend: straight and off mirrors
/// @return  [waves]
std::vector<BandArray> arrival_gains(std::span<const BentWave> waves,
                                     std::span<const Arrival> others, double speed_m_per_s);

}  // namespace earpoint

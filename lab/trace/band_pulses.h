#pragma once

#include "wedge_diffraction.h"

#include <vector>

#include <earpoint/core/octave_bands.h>

namespace earpoint {

/// A part of an arrival.
struct BandPulse {
  double later_s = 0.0;  ///< than the arrival
  BandArray gain{};
};

/// Pulses that have a spectrum's phase as well as its energy. Diffracted sound lags by up to half a
/// period, which no gain says; where it meets other sound it matters. So a pulse at the arrival's
/// time is joined by one for each band, for each two from 1 kHz on, a quarter of their period
/// later: two pulses make any phase.
/// @return  the first with `later_s` 0
std::vector<BandPulse> band_pulses(const DiffractionSpectrum& spectrum);

}  // namespace earpoint

#pragma once

#include <span>

#include <earpoint/spatial/arrival.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The binaural room impulse response of single arrivals: each with its band gains (the octave
/// bank's curve), through the HRTF of its direction, at its exact time. Sample 0 is the moment of
/// emission; an arrival passes the middle of the head at delay_s.
///
/// Arrivals of up to two reflections take the interpolated HRTF, later ones the nearest measured
/// one: those come from too many sides to be told apart. Times are exact to a fraction of a sample
/// (a nonuniform Fourier transform: 3e-6 of the sum of gains in float32). From 3 ms before the
/// first arrival on backwards the response is exactly zero.
///
/// @param arrivals  sorted by delay
/// @param length_s  > 0; what lies beyond is cut off
/// @return  shape [2][round(length_s * rate)] at the set's rate
/// @throws std::logic_error if the arrivals are not sorted or a delay is negative
/// Cost: about twelve Fourier transforms of the whole length per distinct direction, whatever the
/// number of arrivals: 235,000 arrivals of half a second at 16 kHz take about 2 s on one core.
[[nodiscard]] Waveform render_arrivals(std::span<const Arrival> arrivals, const HrtfSet& hrtf,
                                       double length_s);

/// The same for an omnidirectional microphone: unit gain puts a unit impulse, band-limited, at
/// delay_s. Zero from 4 ms before the first arrival on backwards.
/// @return  shape [1][round(length_s * rate)]
[[nodiscard]] Waveform render_arrivals_mono(std::span<const Arrival> arrivals, int sample_rate_hz,
                                            double length_s);

}  // namespace earpoint

#pragma once

#include "late_field.h"

#include <span>
#include <vector>

#include <earpoint/pose.h>
#include <earpoint/spatial/arrival.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint {

/// Adds arrivals, each through the HRTF of its own direction at its own time: the gain curve of its
/// bands times both ears' responses, shifted by the fraction of a sample. The first 256 get the
/// interpolated response, later ones that of the nearest measured direction: hearing does not
/// resolve them apart.
/// @param bank      of `shape.fft_size`
/// @param arrivals  by delay, directions in the world's frame
/// @param ears      [ear][samples]
void add_early_binaural(const ResponseShape& shape, const OctaveBank& bank,
                        std::span<const Arrival> arrivals, const Quaternion& world_from_listener,
                        const HrtfSet& hrtf, std::span<std::vector<float>> ears);

}  // namespace earpoint

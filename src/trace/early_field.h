#pragma once

#include "late_field.h"

#include <span>
#include <vector>

#include <earpoint/core/pose.h>
#include <earpoint/spatial/arrival.h>
#include <earpoint/spatial/hrtf.h>

namespace earpoint {

/// Adds arrivals, each through the HRTF of its own direction at its own time: the gain curve of its
/// bands times both ears' responses, shifted by the fraction of a sample.
/// @param arrivals  directions in the world's frame
/// @param ears      [ear][samples]
void add_early_binaural(const ResponseShape& shape, std::span<const Arrival> arrivals,
                        const Quaternion& world_from_listener, const HrtfSet& hrtf,
                        std::span<std::vector<float>> ears);

}  // namespace earpoint

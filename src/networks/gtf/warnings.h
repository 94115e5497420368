#pragma once

#include <string>
#include <vector>

#include <earpoint/gtf/description.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

/// What in a rendering lies outside gtf's training data (GtfDescription::training_range), one line
/// each.
/// @param horizontal_fov_rad  of the source camera
[[nodiscard]] std::vector<std::string> gtf_warnings(const GtfDescription& description,
                                                    const RenderOutline& outline,
                                                    double horizontal_fov_rad);

}  // namespace earpoint

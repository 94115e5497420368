#pragma once

#include <string>
#include <vector>

#include <earpoint/gtf/description.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

/// What in a rendering lies outside gtf's training data, one line each. The limits are those of the
/// simulated conversations that it is trained on (ConversationOptions): viewpoints within 2.5 m of
/// the middle between two people, all at one height, all level.
/// @param horizontal_fov_rad  of the source camera
[[nodiscard]] std::vector<std::string> gtf_warnings(const GtfDescription& description,
                                                    const RenderOutline& outline,
                                                    double horizontal_fov_rad);

}  // namespace earpoint

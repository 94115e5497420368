#pragma once

#include <string>
#include <vector>

#include <earpoint/gtf/description.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

/// What of a rendering a gtf network has never met in training, one reason each. The limits are
/// those of the simulated conversations that it learns from (ConversationOptions): viewpoints
/// within 2.5 m of the middle between two people, all at one height, all level.
/// @param horizontal_fov_rad  of the source camera
[[nodiscard]] std::vector<std::string> gtf_doubts(const GtfDescription& description,
                                                  const RenderOutline& outline,
                                                  double horizontal_fov_rad);

}  // namespace earpoint

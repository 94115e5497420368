#pragma once

#include <nlohmann/json.hpp>

#include <earpoint/network/pose_encoding.h>

namespace earpoint {

/// The options that the released code stores with a checkpoint of the published network, in the
/// order of its command line.
/// @param encoding  soundspaces or replay: whose data set
[[nodiscard]] nlohmann::ordered_json released_options(PoseEncoding encoding);

}  // namespace earpoint

#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include <earpoint/network/weights.h>
#include <earpoint/vam/description.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// A network for visual acoustic matching, every tensor checked.
using VamWeights = NetworkWeights<VamDescription>;

/// @throws InputError as checked_weights()
[[nodiscard]] VamWeights vam_weights(SafetensorsFile file, std::string_view where);
[[nodiscard]] VamWeights read_vam_weights(const std::filesystem::path& path);

}  // namespace earpoint

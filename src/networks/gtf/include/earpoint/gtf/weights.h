#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include <earpoint/gtf/description.h>
#include <earpoint/network/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// A gtf network, every tensor checked.
using GtfWeights = NetworkWeights<GtfDescription>;

/// A file without a training range has the usual one.
/// @throws InputError as checked_weights()
[[nodiscard]] GtfWeights gtf_weights(SafetensorsFile file, std::string_view where);
[[nodiscard]] GtfWeights read_gtf_weights(const std::filesystem::path& path);

/// As to_weight_file() of other networks, with the training range beside the description.
[[nodiscard]] SafetensorsFile to_weight_file(const GtfWeights& weights,
                                             std::map<std::string, std::string> metadata = {});

}  // namespace earpoint

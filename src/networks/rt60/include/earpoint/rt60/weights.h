#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include <earpoint/network/weights.h>
#include <earpoint/rt60/description.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// An estimator of reverberation time, every tensor checked.
using Rt60EstimatorWeights = NetworkWeights<Rt60Description>;

/// @throws InputError as checked_weights()
[[nodiscard]] Rt60EstimatorWeights rt60_estimator_weights(SafetensorsFile file,
                                                          std::string_view where);
[[nodiscard]] Rt60EstimatorWeights read_rt60_estimator_weights(const std::filesystem::path& path);

}  // namespace earpoint

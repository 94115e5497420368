#pragma once

#include <filesystem>
#include <optional>

namespace earpoint {

/// What to say where rt60_model() finds nothing.
inline constexpr const char* kNoRt60Model =
    "found no rt60.safetensors among the shipped models, so rte_s is left out; "
    "give --rt60-model, or set EARPOINT_MODELS_DIR to the folder that holds it";

/// The weight file of the estimator behind rte_s.
/// @param given  by --rt60-model; empty: the shipped one
/// @return nothing if none is given and none is shipped
std::optional<std::filesystem::path> rt60_model(const std::filesystem::path& given);

}  // namespace earpoint

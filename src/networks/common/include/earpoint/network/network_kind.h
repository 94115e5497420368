#pragma once

#include <string_view>

#include <earpoint/weights/safetensors.h>

namespace earpoint {

enum class NetworkKind { vigas, gtf, rt60_estimator, vam, people };

/// What a weight file is of, by its description.
/// @param where  the file, for messages
/// @throws InputError if the file has no description or one of an unknown network
[[nodiscard]] NetworkKind network_kind(const SafetensorsFile& file, std::string_view where);

/// As a description has it, e.g. "gtf".
[[nodiscard]] std::string_view name_of(NetworkKind kind);

}  // namespace earpoint

#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include <earpoint/network/weights.h>
#include <earpoint/people/description.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// A network that finds people, every tensor checked.
using PeopleWeights = NetworkWeights<PeopleDescription>;

/// @throws InputError as checked_weights()
[[nodiscard]] PeopleWeights people_weights(SafetensorsFile file, std::string_view where);
[[nodiscard]] PeopleWeights read_people_weights(const std::filesystem::path& path);

}  // namespace earpoint

#include "description_section.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>

namespace earpoint {

std::string description_with(std::string_view section, std::string_view usual,
                             std::string_view where) {
  constexpr int kDepth = 4;
  const nlohmann::json changes = parse_strict_json(section, where, kDepth);
  if (!changes.is_object()) throw InputError(where, "expected an object");
  nlohmann::json whole = nlohmann::json::parse(usual);
  for (const auto& [key, value] : changes.items()) {
    if (key == "format" || key == "network") {
      throw InputError(where, fmt::format("'{}' cannot be set by a configuration", key));
    }
    whole[key] = value;
  }
  return whole.dump();
}

}  // namespace earpoint

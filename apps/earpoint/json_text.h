#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace earpoint {

/// JSON to be printed. Bytes that are no UTF-8, as file names may hold, become U+FFFD.
template <typename Json>
std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace earpoint

#include <earpoint/core/strict_json.h>

#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/quote.h>
#include <earpoint/error.h>

namespace earpoint {

using Json = nlohmann::json;

Json parse_strict_json(std::string_view text, std::string_view where, int max_depth) {
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  const auto watch = [&](int depth, Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::object_start || event == Json::parse_event_t::array_start) {
      if (depth >= max_depth) throw InputError(where, "is nested too deeply");
    }
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key) {
      const auto& key = parsed.get_ref<const std::string&>();
      if (!keys.back().insert(key).second) {
        throw InputError(where, fmt::format("key {} occurs twice", in_quotes(key)));
      }
    }
    return true;
  };
  // The library's parser takes a NUL for the end.
  if (text.find('\0') != std::string_view::npos) throw InputError(where, "is not valid JSON");
  try {
    return Json::parse(text.begin(), text.end(), watch);
  } catch (const Json::parse_error& error) {
    throw InputError(where, fmt::format("is not valid JSON at byte {}", error.byte));
  } catch (const Json::out_of_range&) {  // a number beyond double
    throw InputError(where, "has a number that is too large");
  }
}

JsonObjectReader::JsonObjectReader(const Json& object, std::string_view where)
    : object_(object, std::string(where)) {
  if (!object.is_object()) object_.fail("an object");
}

bool JsonObjectReader::has(const std::string& key) const { return object_.has(key); }

JsonField JsonObjectReader::field(const std::string& key) {
  taken_.insert(key);
  return object_.field(key);
}

const Json& JsonObjectReader::list(const std::string& key) {
  const JsonField found = field(key);
  if (!found.json().is_array()) found.fail("a list");
  return found.json();
}

void JsonObjectReader::expect_nothing_else() const {
  for (const auto& [key, unused] : object_.json().items()) {
    if (!taken_.contains(key)) object_.refuse(fmt::format("unknown key {}", in_quotes(key)));
  }
}

}  // namespace earpoint

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
    : object_(object), where_(where) {
  if (!object.is_object()) {
    throw InputError(where, fmt::format("expected an object, found {}", object.type_name()));
  }
}

void JsonObjectReader::fail(const std::string& key, std::string_view expected,
                            const Json& found) const {
  const std::string text = found.dump(-1, ' ', false, Json::error_handler_t::replace);
  throw InputError(where_, fmt::format("{}: expected {}, found {}", in_quotes(key), expected,
                                       text.size() <= 60 ? text : text.substr(0, 60) + "..."));
}

bool JsonObjectReader::has(const std::string& key) const { return object_.contains(key); }

const Json& JsonObjectReader::value(const std::string& key) {
  const auto found = object_.find(key);
  if (found == object_.end()) throw InputError(where_, fmt::format("has no {}", in_quotes(key)));
  taken_.insert(key);
  return *found;
}

std::string JsonObjectReader::string(const std::string& key) {
  const Json& found = value(key);
  if (!found.is_string()) fail(key, "a string", found);
  return found.get<std::string>();
}

int JsonObjectReader::integer(const std::string& key) {
  const Json& found = value(key);
  constexpr int kMost = std::numeric_limits<int>::max();
  const bool fits = found.is_number_unsigned()
                        ? found.get<std::uint64_t>() <= unsigned{kMost}
                        : found.is_number_integer() && found.get<std::int64_t>() >= -kMost;
  if (!fits) fail(key, "an integer", found);
  return found.get<int>();
}

double JsonObjectReader::number(const std::string& key) {
  const Json& found = value(key);
  if (!found.is_number()) fail(key, "a number", found);
  return found.get<double>();
}

bool JsonObjectReader::boolean(const std::string& key) {
  const Json& found = value(key);
  if (!found.is_boolean()) fail(key, "true or false", found);
  return found.get<bool>();
}

const Json& JsonObjectReader::list(const std::string& key) {
  const Json& found = value(key);
  if (!found.is_array()) fail(key, "a list", found);
  return found;
}

void JsonObjectReader::expect_nothing_else() const {
  for (const auto& [key, unused] : object_.items()) {
    if (!taken_.contains(key))
      throw InputError(where_, fmt::format("unknown key {}", in_quotes(key)));
  }
}

}  // namespace earpoint

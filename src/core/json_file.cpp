#include <earpoint/core/json_file.h>

#include <algorithm>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kMostDepth = 64;

/// How many lists and objects of a JSON text are inside each other. The library's parser can say so
/// too, but is then many times slower.
int depth_of(std::string_view text) {
  int depth = 0;
  int deepest = 0;
  bool is_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') is_string = !is_string;
    if (is_string) {
      if (c == '\\') ++i;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return deepest;
}

template <typename Json>
Json parse_as(std::string_view text, std::string_view where) {
  if (depth_of(text) > kMostDepth) throw InputError(where, "is nested too deeply");
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) throw InputError(where, "is not valid JSON");
  return json;
}

}  // namespace

nlohmann::json parse_json(std::string_view text, std::string_view where) {
  return parse_as<nlohmann::json>(text, where);
}

nlohmann::json read_json(const std::filesystem::path& path) {
  return parse_json(read_text_file(path), path.string());
}

nlohmann::ordered_json parse_ordered_json(std::string_view text, std::string_view where) {
  return parse_as<nlohmann::ordered_json>(text, where);
}

nlohmann::ordered_json read_ordered_json(const std::filesystem::path& path) {
  return parse_ordered_json(read_text_file(path), path.string());
}

}  // namespace earpoint

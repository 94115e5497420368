#pragma once

#include <set>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include <earpoint/core/json_field.h>

namespace earpoint {

/// Parses one JSON value. Unlike the library's own parser it refuses repeated keys and more than
/// `max_depth` nested lists and objects, so that a small text cannot become a large tree.
/// @param where  the file and field, for messages
/// @throws InputError
nlohmann::json parse_strict_json(std::string_view text, std::string_view where, int max_depth);

/// Reads an object key by key: a key that is missing, of another type or left over is an error.
class JsonObjectReader {
 public:
  /// @param object  must outlive this; if it is not an object, InputError
  JsonObjectReader(const nlohmann::json& object, std::string_view where);

  /// Whether the object has that key.
  [[nodiscard]] bool has(const std::string& key) const;

  /// @throws InputError if the key is missing
  JsonField field(const std::string& key);
  const nlohmann::json& value(const std::string& key) { return field(key).json(); }

  /// Each: @throws InputError if the key is missing or its value is of another type
  std::string string(const std::string& key) { return field(key).text(); }
  int integer(const std::string& key) { return field(key).integer(); }
  double number(const std::string& key) { return field(key).number(); }
  bool boolean(const std::string& key) { return field(key).boolean(); }
  const nlohmann::json& list(const std::string& key);

  /// @throws InputError if a key was not asked for
  void expect_nothing_else() const;

 private:
  JsonField object_;
  std::set<std::string> taken_;
};

}  // namespace earpoint

#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <earpoint/vector3.h>

namespace earpoint {

/// A value in a JSON document that knows where it stands, so that errors can say so.
class JsonField {
 public:
  /// @param value  must outlive this
  /// @param file   the document's name, for messages
  /// @param path   of the value in it, e.g. "cameras[0].name"; empty: the whole
  JsonField(const nlohmann::json& value, std::string file, std::string path = {})
      : value_(value), file_(std::move(file)), path_(std::move(path)) {}

  /// @throws InputError if this is no object or has no such field
  [[nodiscard]] JsonField field(const std::string& key) const;
  /// @throws InputError if this is no object
  [[nodiscard]] bool has(const std::string& key) const;
  /// @throws InputError naming a field that is none of these, such as a misspelt one
  void expect_only(std::initializer_list<std::string_view> keys) const;
  [[nodiscard]] bool is_null() const { return value_.is_null(); }
  [[nodiscard]] bool is_text() const { return value_.is_string(); }
  /// @throws InputError if this is no list
  [[nodiscard]] std::vector<JsonField> items() const;
  /// The fields of an object with their names.
  [[nodiscard]] std::vector<std::pair<std::string, JsonField>> fields() const;

  /// The value itself.
  [[nodiscard]] const nlohmann::json& json() const { return value_; }

  [[nodiscard]] std::string text() const;
  [[nodiscard]] double number() const;
  [[nodiscard]] int integer() const;
  [[nodiscard]] bool boolean() const;
  /// A list of exactly three numbers.
  [[nodiscard]] Vector3 vector3() const;

  /// The file, and the path of the value in it.
  [[nodiscard]] std::string where() const;
  /// @throws InputError always
  [[noreturn]] void refuse(const std::string& problem, std::string_view hint = {}) const;
  /// @throws InputError always: what was expected here, and what was found
  [[noreturn]] void fail(const std::string& expected) const;

 private:
  [[nodiscard]] JsonField below(const nlohmann::json& value, const std::string& key) const;

  const nlohmann::json& value_;
  std::string file_;
  std::string path_;
};

}  // namespace earpoint

#include <earpoint/core/json_field.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <earpoint/error.h>

namespace earpoint {

namespace {

constexpr std::size_t kShown = 60;  // bytes of a value in a message

std::string scalar_text(const nlohmann::json& value) {
  return value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

/// Appends a value as dump() writes it, until there is more than a message shows. So a value that
/// is large or nested deeply costs nothing.
void append_beginning(const nlohmann::json& value, std::string& text) {
  if (text.size() > kShown) return;
  if (!value.is_structured()) {
    text += scalar_text(value);
    return;
  }
  text += value.is_array() ? '[' : '{';
  bool is_first = true;
  for (const auto& [key, element] : value.items()) {
    if (text.size() > kShown) return;
    if (!is_first) text += ',';
    is_first = false;
    if (value.is_object()) text += scalar_text(key) + ':';
    append_beginning(element, text);
  }
  text += value.is_array() ? ']' : '}';
}

}  // namespace

void JsonField::fail(const std::string& expected) const {
  std::string found;
  append_beginning(value_, found);
  if (found.size() > kShown) found = found.substr(0, kShown) + "...";
  refuse("expected " + expected + ", found " + found);
}

std::string JsonField::where() const { return path_.empty() ? file_ : file_ + ": " + path_; }

void JsonField::refuse(const std::string& problem, std::string_view hint) const {
  throw InputError(where(), problem, hint);
}

bool JsonField::has(const std::string& key) const {
  if (!value_.is_object()) fail("an object");
  return value_.contains(key);
}

JsonField JsonField::field(const std::string& key) const {
  if (!has(key)) refuse("the field '" + key + "' is missing");
  return below(value_.at(key), key);
}

void JsonField::expect_only(std::initializer_list<std::string_view> keys) const {
  for (const auto& [key, value] : fields()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    value.refuse("is not known", fmt::format("use {}", fmt::join(keys, ", ")));
  }
}

JsonField JsonField::below(const nlohmann::json& value, const std::string& key) const {
  return {value, file_, path_.empty() ? key : path_ + "." + key};
}

std::vector<JsonField> JsonField::items() const {
  if (!value_.is_array()) fail("a list");
  std::vector<JsonField> result;
  for (std::size_t i = 0; i < value_.size(); ++i) {
    result.emplace_back(value_[i], file_, fmt::format("{}[{}]", path_, i));
  }
  return result;
}

std::vector<std::pair<std::string, JsonField>> JsonField::fields() const {
  if (!value_.is_object()) fail("an object");
  std::vector<std::pair<std::string, JsonField>> result;
  for (const auto& [key, value] : value_.items()) {
    result.emplace_back(key, below(value, key));
  }
  return result;
}

std::string JsonField::text() const {
  if (!value_.is_string()) fail("a text");
  return value_.get<std::string>();
}

double JsonField::number() const {
  if (!value_.is_number() || !std::isfinite(value_.get<double>())) fail("a finite number");
  return value_.get<double>();
}

int JsonField::integer() const {
  const double value = number();
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
    fail("a whole number");
  }
  return static_cast<int>(value);
}

bool JsonField::boolean() const {
  if (!value_.is_boolean()) fail("true or false");
  return value_.get<bool>();
}

Vector3 JsonField::vector3() const {
  const std::vector<JsonField> values = items();
  if (values.size() != 3) fail("three numbers");
  return {values[0].number(), values[1].number(), values[2].number()};
}

}  // namespace earpoint

#pragma once

#include <filesystem>
#include <string_view>

#include <nlohmann/json.hpp>

namespace earpoint {

/// Parses JSON. Of a repeated key the last value counts; parse_strict_json() refuses that.
/// @param where  what errors call the text, e.g. its file
/// @throws InputError if it is not valid, or has more than 64 lists and objects inside each other:
///         code that walks the value may recurse
[[nodiscard]] nlohmann::json parse_json(std::string_view text, std::string_view where);

/// The same of a file.
/// @throws InputError as read_text_file() and parse_json()
[[nodiscard]] nlohmann::json read_json(const std::filesystem::path& path);

/// The same, with the keys of objects in the order of the text.
[[nodiscard]] nlohmann::ordered_json parse_ordered_json(std::string_view text,
                                                        std::string_view where);
[[nodiscard]] nlohmann::ordered_json read_ordered_json(const std::filesystem::path& path);

}  // namespace earpoint

#pragma once

#include <string_view>

#include <earpoint/core/strict_json.h>

namespace earpoint {

/// Checks the first keys of a description: its `format` and the kind of its `network`.
/// @param where  the file, for messages
/// @throws InputError naming the key, what was expected and what was found
void expect_head(JsonObjectReader& reader, std::string_view where, int format,
                 std::string_view network);

}  // namespace earpoint

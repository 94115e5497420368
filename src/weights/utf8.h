#pragma once

#include <string_view>

namespace earpoint {

/// Whether the text is UTF-8: no stray or missing continuation bytes, no overlong forms, no
/// surrogates, nothing above U+10FFFF.
/// Source: RFC 3629, section 4.
bool is_utf8(std::string_view text);

}  // namespace earpoint

#pragma once

#include <string>
#include <string_view>

namespace earpoint {

/// A name from a file, in quotes, for a message: shortened if it is long, control characters
/// replaced.
std::string in_quotes(std::string_view name);

}  // namespace earpoint

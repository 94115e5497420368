#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace earpoint {

/// Parses "1.0,-0.5,0" into exactly `count` finite numbers.
/// @param flag  names the argument in the message
/// @throws InputError
std::vector<double> parse_numbers(const std::string& text, std::size_t count,
                                  const std::string& flag);

}  // namespace earpoint

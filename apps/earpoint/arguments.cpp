#include "arguments.h"

#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/core/error.h>

namespace earpoint {

std::vector<double> parse_numbers(const std::string& text, std::size_t count,
                                  const std::string& flag) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (true) {
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) break;
    numbers.push_back(value);
    if (next == end && numbers.size() == count) return numbers;
    if (next == end || *next != ',') break;
    at = next + 1;
  }
  throw InputError(flag, fmt::format("expected {} numbers like {}, found '{}'", count,
                                     count == 2   ? "0,1"
                                     : count == 3 ? "1.0,-0.5,0"
                                                  : "0.4,0.2,0.6,0.9",
                                     text));
}

}  // namespace earpoint

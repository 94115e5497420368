#include "flag_checks.h"

#include <charconv>
#include <cstdint>

#include <fmt/format.h>

namespace earpoint {

CLI::Validator whole_number() {
  return {[](const std::string& text) -> std::string {
            std::uint64_t value = 0;
            const char* const last = text.data() + text.size();
            const auto [end, error] = std::from_chars(text.data(), last, value);
            if (error == std::errc() && end == last) return {};
            return fmt::format("expected a whole number of 0 or more, found '{}'", text);
          },
          ""};
}

}  // namespace earpoint

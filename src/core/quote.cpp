#include <earpoint/core/quote.h>

#include <algorithm>

#include <fmt/format.h>

namespace earpoint {

std::string in_quotes(std::string_view name) {
  std::size_t length = std::min<std::size_t>(name.size(), 120);
  // A shortened name ends between characters, not inside of one.
  while (length < name.size() && length > 0 &&
         (static_cast<unsigned char>(name[length]) & 0xC0U) == 0x80U) {
    --length;
  }
  std::string text =
      fmt::format("'{}{}'", name.substr(0, length), length < name.size() ? "..." : "");
  // Nothing in a file may move the cursor of a terminal.
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }, '?');
  return text;
}

}  // namespace earpoint

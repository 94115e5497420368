#pragma once

#include <string>

namespace CLI {
class App;
}

namespace earpoint {

/// The manual page in man's macros (man-pages(7)), of what --help says of all commands.
[[nodiscard]] std::string manual_page(const CLI::App& app, const std::string& version);

}  // namespace earpoint

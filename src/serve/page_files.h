#pragma once

#include <optional>
#include <string_view>

namespace earpoint {

/// A file of the page, as this build holds it.
struct PageFile {
  std::string_view bytes;
  const char* type = nullptr;
};

/// @param path  as it is asked for: "/", "/app.js", ...
/// @return nothing if the page has no such file
[[nodiscard]] std::optional<PageFile> page_file(std::string_view path);

}  // namespace earpoint

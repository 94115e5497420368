#pragma once

#include <span>
#include <string_view>

namespace earpoint::study_page {

struct PageBytes {
  std::string_view name;
  std::string_view bytes;
};

/// The files of web/study, bundled, as the build wrote them; none where esbuild was missing.
[[nodiscard]] std::span<const PageBytes> page_bytes();

}  // namespace earpoint::study_page

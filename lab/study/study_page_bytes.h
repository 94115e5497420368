#pragma once

#include <span>

#include <earpoint/serve/page_server.h>

namespace earpoint::study_page_files {

/// The files of web/study, bundled, as the build wrote them; none where esbuild was missing.
[[nodiscard]] std::span<const PageBytes> page_bytes();

}  // namespace earpoint::study_page_files

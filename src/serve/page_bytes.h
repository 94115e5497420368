#pragma once

#include <span>
#include <string_view>

#include <earpoint/serve/page_server.h>

namespace earpoint {

/// The files of web/, bundled, as the build wrote them; none where esbuild was missing.
[[nodiscard]] std::span<const PageBytes> page_bytes();

/// The one that is there only where the engine for browsers was built before (./dev wasm).
inline constexpr std::string_view kEngineFile = "engine.wasm";

}  // namespace earpoint

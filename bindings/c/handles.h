#pragma once

#include <string>
#include <vector>

#include <earpoint/earpoint.h>
#include <earpoint/renderer.h>

// What the opaque types of earpoint.h are.
// NOLINTBEGIN(readability-identifier-naming): C has no namespaces
struct earpoint_strings {
  std::vector<std::string> texts;
};
struct earpoint_renderer {
  earpoint::Renderer renderer;
};
struct earpoint_stream {
  earpoint::Stream stream;
};
// NOLINTEND(readability-identifier-naming)

#pragma once

#include <CLI/CLI.hpp>

namespace earpoint {

/// `earpoint serve`: a page on which one walks through a clip.
void add_serve_command(CLI::App& app);

}  // namespace earpoint

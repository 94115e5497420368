#pragma once

#include <CLI/CLI.hpp>

namespace earpoint {

/// Adds `earpoint render`.
void add_render_command(CLI::App& app);

}  // namespace earpoint

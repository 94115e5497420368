#pragma once

#include <CLI/CLI.hpp>

namespace earpoint {

/// `earpoint enhance`: the active speaker's voice as a near microphone would record it.
void add_enhance_command(CLI::App& app);

}  // namespace earpoint

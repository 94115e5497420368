#pragma once

#include <CLI/CLI.hpp>

namespace earpoint {

/// `earpoint locate`
void add_locate_command(CLI::App& app);

}  // namespace earpoint

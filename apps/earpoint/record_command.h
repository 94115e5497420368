#pragma once

#include <CLI/CLI.hpp>

namespace earpoint {

/// `earpoint record`: recorded sessions of several cameras.
void add_record_command(CLI::App& app);

// Its subcommands, one file each.
void add_record_prepare_command(CLI::App& record);
void add_record_simulate_command(CLI::App& record);
void add_record_sync_command(CLI::App& record);

}  // namespace earpoint

#pragma once

#include <CLI/CLI.hpp>

namespace earpoint {

/// `earpoint study`: listening studies.
void add_study_command(CLI::App& app);

// Its subcommands.
void add_study_make_command(CLI::App& study);
void add_study_serve_command(CLI::App& study);
void add_study_simulate_command(CLI::App& study);
void add_study_report_command(CLI::App& study);

}  // namespace earpoint

#pragma once

namespace CLI {
class App;
}

/// Adds `earpoint record simulate`.
/// @param record  the command that it belongs to
void add_record_simulate_command(CLI::App& record);

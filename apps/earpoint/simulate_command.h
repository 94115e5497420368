#pragma once

namespace CLI {
class App;
}

/// Adds `earpoint simulate`: data sets of homes, people, pictures and binaural responses.
void add_simulate_command(CLI::App& app);

#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `earpoint simulate`: data sets of homes, people, pictures and binaural responses.
void add_simulate_command(CLI::App& app);

}  // namespace earpoint

#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `earpoint pairs` to the program.
void add_pairs_command(CLI::App& app);

}  // namespace earpoint

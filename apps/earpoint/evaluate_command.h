#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `earpoint evaluate`: methods side by side on a data set's frozen pairs.
void add_evaluate_command(CLI::App& app);

}  // namespace earpoint

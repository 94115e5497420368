#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `earpoint metrics`: compares an estimate with its reference.
void add_metrics_command(CLI::App& app);

}  // namespace earpoint

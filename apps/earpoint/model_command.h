#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `earpoint model`: import, info, run.
void add_model_command(CLI::App& app);

}  // namespace earpoint

#pragma once

namespace CLI {
class App;
}

/// Adds `earpoint model`: import, info, run.
void add_model_command(CLI::App& app);

#pragma once

namespace CLI {
class App;
}

/// Adds `earpoint model`: import, info.
void add_model_command(CLI::App& app);

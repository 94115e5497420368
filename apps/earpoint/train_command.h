#pragma once

namespace CLI {
class App;
}

/// Adds `earpoint train`: learns a network from a data set.
void add_train_command(CLI::App& app);

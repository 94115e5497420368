#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// What `earpoint --help` says of it.
inline constexpr const char* kTrainDescription =
    "Learn a network from a data set. The folder of the run holds best.safetensors, which "
    "`earpoint render --model` takes at once, curves.png, and all that --resume goes on from.";

/// Adds `earpoint train`: learns a network from a data set.
void add_train_command(CLI::App& app);

}  // namespace earpoint

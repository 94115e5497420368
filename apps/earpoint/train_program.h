#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `earpoint train`, which hands over to the program earpoint-train beside this one: loading
/// LibTorch takes most of a second, which no other command shall pay.
/// @param argv  the whole command line, handed on from `train` as it is
void add_train_program(CLI::App& app, char** argv);

}  // namespace earpoint

#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Parses the words of a command line and runs the command that they name. What went wrong is said
/// in one line on standard error.
/// @return  the exit code: 0, 2 for bad input, 1 for a fault of the program
int run_app(CLI::App& app, int argc, char** argv);

}  // namespace earpoint

#pragma once

#include <span>

namespace CLI {
class App;
}

namespace earpoint {

/// `earpoint completion SHELL` prints a script that completes commands and options in that shell;
/// `earpoint manual` prints the manual page. Both read the program's own commands, so that nothing
/// of them can be out of date.
void add_completion_commands(CLI::App& app);

/// `earpoint complete -- WORD...`, which the scripts call: prints what may stand in place of the
/// last word, each in a line with a tab and its meaning. Words look like options, so this is no
/// command of `app`.
/// @param arguments  of the program
/// @return  whether they asked for a completion
bool answer_completion(const CLI::App& app, std::span<char* const> arguments);

}  // namespace earpoint

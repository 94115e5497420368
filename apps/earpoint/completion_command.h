#pragma once

namespace CLI {
class App;
}

/// `earpoint completion SHELL` prints a script that completes commands and options in that shell;
/// `earpoint complete`, which the scripts call, prints what fits, a word and its meaning in each
/// line; `earpoint manual` prints the manual page. All read the program's own commands, so nothing
/// of them can be out of date.
void add_completion_commands(CLI::App& app);

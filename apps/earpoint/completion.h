#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace earpoint {

/// A word that may stand at the place of the cursor, and what it means in one line.
struct Completion {
  std::string word;
  std::string meaning;
};

/// What may follow on the command line, read from the commands and options themselves: subcommands,
/// options, and the values of options that have a fixed choice. Nothing where files or numbers are
/// expected.
/// @param words  those after the program's name; the last is the one to complete, perhaps empty
[[nodiscard]] std::vector<Completion> complete(const CLI::App& app,
                                               const std::vector<std::string>& words);

/// The subcommands that --help lists.
[[nodiscard]] std::vector<const CLI::App*> visible_commands(const CLI::App& app);

/// The options that --help lists, without positionals.
[[nodiscard]] std::vector<const CLI::Option*> visible_options(const CLI::App& app);

}  // namespace earpoint

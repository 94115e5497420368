#pragma once

#include <string>

namespace CLI {
class App;
}

namespace earpoint {

/// A library's message for the command line: the name of a setting becomes the flag of the command
/// that sets it. "layout: expected ..." becomes "--layout: expected ...", and "...; choose another
/// port" becomes "...; choose another port (--port)".
/// @param command  flags that it does not have are left out; null: the command has them all
[[nodiscard]] std::string with_flags(const std::string& message, const CLI::App* command = nullptr);

/// The innermost subcommand that was given, or the program itself.
[[nodiscard]] const CLI::App& given_command(const CLI::App& app);

}  // namespace earpoint

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace earpoint {

/// What a program left behind.
struct ProgramOutcome {
  int exit_code = -1;
  std::string output;  ///< standard output
  std::string errors;  ///< standard error
};

/// Runs a program and waits for it. Any thread may.
/// @param arguments    as the program gets them; no shell reads them
/// @param environment  NAME=VALUE, beside what this process has
ProgramOutcome run_program(const std::filesystem::path& program,
                           const std::vector<std::string>& arguments,
                           const std::vector<std::string>& environment = {});

/// The same for the earpoint program that was built beside the tests.
ProgramOutcome run_earpoint(const std::vector<std::string>& arguments,
                            const std::vector<std::string>& environment = {});

}  // namespace earpoint

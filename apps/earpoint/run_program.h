#pragma once

#include <string>
#include <vector>

/// What a program left behind.
struct ProgramOutcome {
  int exit_code = -1;
  std::string output;  ///< standard output
  std::string errors;  ///< standard error
};

/// Runs the earpoint program that was built beside the tests and waits for it.
/// @param arguments  as the program gets them; no shell reads them
ProgramOutcome run_earpoint(const std::vector<std::string>& arguments);

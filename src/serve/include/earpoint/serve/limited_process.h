#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace earpoint {

/// What a process may use before the system ends it.
struct ProcessLimits {
  std::chrono::seconds processor_time{60};
  std::chrono::seconds wall_time{120};
  std::size_t memory_bytes = std::size_t{4} << 30U;  ///< address space
  std::size_t file_bytes = std::size_t{1} << 30U;    ///< of each file that it writes
};

/// How a process ended.
struct ProcessEnd {
  int exit_code = -1;           ///< -1: it was ended by a signal
  bool is_out_of_time = false;  ///< of either kind
  std::string errors;           ///< what it wrote to standard error, the first 4 kB
};

/// Runs a program of its own process on what is not to be trusted: it may crash, hang or ask for
/// everything, and this process goes on. It has no standard input, and its output goes nowhere.
/// @throws std::system_error if no process can be started
[[nodiscard]] ProcessEnd run_limited(const std::filesystem::path& program,
                                     const std::vector<std::string>& arguments,
                                     const ProcessLimits& limits);

}  // namespace earpoint

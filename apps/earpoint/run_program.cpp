#include "run_program.h"

#include <array>
#include <atomic>
#include <stdexcept>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <earpoint/core/file.h>

namespace earpoint {

namespace fs = std::filesystem;

namespace {

/// A list of words as the system takes it; the words must outlive it.
std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

ProgramOutcome run_program(const fs::path& program, const std::vector<std::string>& arguments,
                           const std::vector<std::string>& environment) {
  static std::atomic<int> runs = 0;
  const std::string stem =
      (fs::temp_directory_path() /
       ("earpoint_run_" + std::to_string(::getpid()) + "_" + std::to_string(++runs)))
          .string();
  const std::array<std::string, 2> captured{stem + ".out", stem + ".err"};

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (int i = 0; i < 2; ++i) {
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO + i, captured[i].c_str(),
                                     O_CREAT | O_TRUNC | O_WRONLY, 0600);
  }
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> variables = environment;
  for (char** variable = environ; *variable != nullptr; ++variable)
    variables.emplace_back(*variable);

  pid_t child = 0;
  const int error = posix_spawn(&child, program.c_str(), &actions, nullptr,
                                pointers_to(words).data(), pointers_to(variables).data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot start " + program.string());
  int status = 0;
  if (::waitpid(child, &status, 0) != child)
    throw std::runtime_error("cannot wait for the program");

  ProgramOutcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text_file(captured[0]),
                         read_text_file(captured[1])};
  for (const std::string& path : captured) fs::remove(path);
  return outcome;
}

ProgramOutcome run_earpoint(const std::vector<std::string>& arguments,
                            const std::vector<std::string>& environment) {
  return run_program(EARPOINT_PROGRAM, arguments, environment);
}

}  // namespace earpoint

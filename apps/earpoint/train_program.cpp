#include "train_program.h"

#include "train_command.h"

#include <cstdlib>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include <earpoint/core/platform/program_path.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

void hand_over(char** argv) {
  const fs::path program = program_path().parent_path() / "earpoint-train";
  // OpenMP reads it once, when a program starts. By default its threads wait for work by spinning,
  // which takes the cores from the thread that makes examples, and from whatever else runs.
  constexpr int kKeepTheUsers = 0;
  ::setenv("OMP_WAIT_POLICY", "passive", kKeepTheUsers);
  ::execv(program.c_str(), argv);
  throw InputError("train", "cannot start " + program.string(),
                   "keep earpoint-train in the same folder as earpoint");
}

}  // namespace

void add_train_program(CLI::App& app, char** argv) {
  CLI::App* command = app.add_subcommand("train", kTrainDescription);
  command->prefix_command();
  command->set_help_flag();
  command->callback([argv] { hand_over(argv); });
}

}  // namespace earpoint

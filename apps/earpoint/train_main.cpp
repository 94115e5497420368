// earpoint-train: the program that `earpoint train` runs, the only one that loads LibTorch.
#include "run_app.h"
#include "train_command.h"

#include <CLI/CLI.hpp>

int main(int argc, char** argv) {
  CLI::App app("Earpoint: hear a recorded moment from another place.", "earpoint");
  app.require_subcommand(1);
  app.set_version_flag("--version", EARPOINT_VERSION);
  earpoint::add_train_command(app);
  return earpoint::run_app(app, argc, argv);
}

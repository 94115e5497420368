#include "evaluate_command.h"
#include "locate_command.h"
#include "metrics_command.h"
#include "model_command.h"
#include "render_command.h"
#include "simulate_command.h"
#include "trace_command.h"
#if defined(EARPOINT_TRAIN)
#include "train_command.h"
#endif
#include "view_command.h"

#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include <earpoint/core/error.h>

int main(int argc, char** argv) {
  CLI::App app("Earpoint: hear a recorded moment from another place.", "earpoint");
  app.require_subcommand(1);
  app.set_version_flag("--version", EARPOINT_VERSION);
  add_evaluate_command(app);
  earpoint::add_locate_command(app);
  add_metrics_command(app);
  earpoint::add_render_command(app);
  add_model_command(app);
  add_simulate_command(app);
  add_trace_command(app);
#if defined(EARPOINT_TRAIN)
  add_train_command(app);
#endif
  add_view_command(app);
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::fprintf(stderr, "earpoint: %s; --help tells more\n", error.what());
    return 2;
  } catch (const earpoint::InputError& error) {
    std::fprintf(stderr, "earpoint: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "earpoint: internal error: %s\n", error.what());
    return 1;
  }
}

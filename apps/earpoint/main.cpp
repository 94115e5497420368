#include "completion_command.h"
#include "enhance_command.h"
#include "evaluate_command.h"
#include "locate_command.h"
#include "metrics_command.h"
#include "model_command.h"
#include "pairs_command.h"
#include "render_command.h"
#include "responses_command.h"
#include "run_app.h"
#if !defined(EARPOINT_RENDER_ONLY)
#include "record_command.h"
#include "serve_command.h"
#include "served_upload.h"
#include "simulate_command.h"
#include "study_command.h"
#include "trace_command.h"
#include "view_command.h"
#endif
#if defined(EARPOINT_TRAIN)
#include "train_program.h"
#endif

#include <CLI/CLI.hpp>

int main(int argc, char** argv) {
  CLI::App app("Earpoint: hear a recorded moment from another place.", "earpoint");
  app.require_subcommand(1);
  app.set_version_flag("--version", EARPOINT_VERSION);
  earpoint::add_enhance_command(app);
  earpoint::add_evaluate_command(app);
  earpoint::add_locate_command(app);
  earpoint::add_metrics_command(app);
  earpoint::add_pairs_command(app);
#if !defined(EARPOINT_RENDER_ONLY)
  earpoint::add_record_command(app);
#endif
  earpoint::add_render_command(app);
  earpoint::add_responses_command(app);
  earpoint::add_model_command(app);
#if defined(EARPOINT_RENDER_ONLY)
  app.footer("This build only renders and measures; `./dev build` builds the whole program.");
#else
  earpoint::add_serve_command(app);
  earpoint::add_unpack_command(app);
  earpoint::add_simulate_command(app);
  earpoint::add_study_command(app);
  earpoint::add_trace_command(app);
#if defined(EARPOINT_TRAIN)
  earpoint::add_train_program(app, argv);
#endif
  earpoint::add_view_command(app);
#endif
  earpoint::add_completion_commands(app);
  if (earpoint::answer_completion(app, {argv, static_cast<std::size_t>(argc)})) return 0;
  return earpoint::run_app(app, argc, argv);
}

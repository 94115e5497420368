#include "serve_command.h"

#include "source_arguments.h"

#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>

#include <earpoint/core/error.h>
#include <earpoint/core/pose.h>
#include <earpoint/core/progress.h>
#include <earpoint/model/shipped_model.h>
#include <earpoint/serve/clip_server.h>

namespace earpoint {
namespace {

constexpr const char* kFooter = R"(
Examples:
  # walk through a clip in the browser
  earpoint serve clip.mp4

  # a recording without a picture, the speaker two metres ahead, always under one address
  earpoint serve sound.flac --speaker 2,0,0 --port 8080

Only this computer reaches the page; Ctrl-C ends it.)";

struct ServeArguments {
  SourceArguments source;
  std::string model;
  int port = 0;
  bool quiet = false;
};

std::string model_of(const ServeArguments& arguments) {
  if (!arguments.model.empty()) return arguments.model;
  if (const auto path = shipped_model_path("gtf.safetensors")) return path->string();
  throw InputError("serve", "finds no gtf.safetensors among the shipped models",
                   "name a gtf weight file with --model");
}

void run_serve(const ServeArguments& arguments) {
  if (!has_page()) {
    throw InputError("serve", "this build has no page",
                     "install esbuild and build again (./dev build does both)");
  }
  const RenderSource source = parse_source(arguments.source);
  const double fov_rad =
      radians_from_degrees(fov_deg_of(arguments.source, source, !arguments.quiet));
  SilentProgress silent;
  StreamProgress stream(stderr);
  ProgressSink& progress = arguments.quiet ? static_cast<ProgressSink&>(silent) : stream;
  const ServedClip clip = open_served_clip(source, model_of(arguments), fov_rad, progress);
  for (const std::string& warning : clip.warnings) {
    fmt::print(stderr, "earpoint: warning: {}: {}\n", clip.name, warning);
  }
  ClipServer server(clip, {.port = arguments.port});
  const int port = server.bind();
  fmt::print("Listen at http://127.0.0.1:{}/ (Ctrl-C ends it)\n", port);
  std::fflush(stdout);
  server.run();
}

}  // namespace

void add_serve_command(CLI::App& app) {
  auto arguments = std::make_shared<ServeArguments>();
  CLI::App* command =
      app.add_subcommand("serve", "Open a page on which you walk through a clip and hear it.");
  command->footer(kFooter);
  add_source_inputs(*command, arguments->source);
  command
      ->add_option("--speaker", arguments->source.speaker,
                   "x,y,z of the speaker's mouth in metres, if it is known")
      ->group("Who speaks");
  add_box_options(*command, arguments->source);
  add_channel_option(*command, arguments->source);
  command->add_option("--model", arguments->model, "A gtf weight file (default: the shipped one)");
  command->add_option("--port", arguments->port, "Of http://127.0.0.1; 0 takes any that is free")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  command->add_flag("--quiet", arguments->quiet, "No progress");
  command->callback([arguments] { run_serve(*arguments); });
}

}  // namespace earpoint

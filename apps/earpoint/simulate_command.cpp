#include "simulate_command.h"

#include "flag_advice.h"
#include "flag_checks.h"
#include "simulate_report.h"
#include "simulate_run.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/core/progress.h>

namespace earpoint {
namespace {

struct Options {
  SimulateOptions what;
  bool quiet = false;
  bool json = false;
};

void run(const Options& options) {
  StreamProgress bar(stderr);
  SilentProgress silent;
  ProgressSink& progress = options.quiet ? static_cast<ProgressSink&>(silent) : bar;
  const auto warn = [&bar](const std::filesystem::path& file, const std::string& warning) {
    bar.note(fmt::format("earpoint: {}: {}", file.string(), with_flags(warning)));
  };
  const GenerationSummary summary = simulate(options.what, warn, progress);
  if (options.json) {
    fmt::print("{}", json_of(summary));
  } else if (!options.quiet) {
    fmt::print("{}", simulation_report(summary));
  }
}

void add_what(CLI::App& command, Options& options) {
  WorkOrder& order = options.what.generation.order;
  command
      .add_option(
          "--scenes", order.scenes,
          "Number of homes, split 90 : 10 : 20 into train, val and test; with a single home "
          "its conversations are split instead")
      ->capture_default_str();
  command
      .add_option("--scene", options.what.scenes,
                  "Scans or models of your own instead (.glb, .gltf, .obj, .ply)")
      ->excludes("--scenes");
  command.add_option(
      "--materials", options.what.materials,
      "Acoustic materials of the surfaces of --scene (JSON); default: the standard table");
  command.add_option("--up", options.what.up_axis, "Axis that points up in --scene")
      ->check(CLI::IsMember({"y", "z"}));
  command.add_option("--unit", options.what.unit_m, "Length of the unit of --scene, metres");
  command.add_flag("--close-ceiling", options.what.close_ceiling,
                   "Add a ceiling to --scene where it has none");
  command.add_option("--conversations", order.conversations, "Conversations in each scene")
      ->capture_default_str();
  command.add_option("--split", options.what.split, "Put everything into this split");
  command.add_option("--speech", options.what.speech,
                     "Folder of recorded speech: LibriSpeech, or with a speech.csv (file, speaker, "
                     "gender); default: what ./dev speech gathers");
}

void add_how(CLI::App& command, Options& options) {
  GenerationOptions& generation = options.what.generation;
  command.add_option("--seed", generation.seed, "The same seed gives the same bytes")
      ->check(whole_number())
      ->capture_default_str();
  command
      .add_option("--viewpoints", generation.conversation.viewpoints,
                  "Viewpoints of each conversation")
      ->capture_default_str();
  command
      .add_option("--reach", generation.conversation.viewpoint_reach_m,
                  "Largest distance of the viewpoints from the middle between the speakers, metres")
      ->capture_default_str();
  command
      .add_option(
          "--other-rooms", generation.conversation.other_room_share,
          "Share of the viewpoints, except the first of a conversation, in other rooms without "
          "sight of the speakers")
      ->capture_default_str();
  command
      .add_option("--other-rooms-reach", generation.conversation.other_room_reach_m,
                  "Largest distance of those from the middle between the speakers, metres")
      ->capture_default_str();
  command
      .add_option("--height-spread", generation.conversation.height_spread_m,
                  "Largest difference of the viewpoints' height to 1.5 m, metres")
      ->capture_default_str();
  command.add_option("--rays", generation.quality.rays, "Rays that leave each speaker")
      ->capture_default_str();
  command.add_option("--rate", generation.quality.sample_rate_hz, "Sample rate of the responses")
      ->capture_default_str();
  command
      .add_option("--duration", generation.quality.duration_s, "Length of the responses, seconds")
      ->capture_default_str();
  command.add_option("--path-prefix", generation.path_prefix,
                     "Put before every path in the metadata, e.g. data/synthetic_dataset/v16");
  command.add_flag("--released-speech", options.what.released_speech,
                   "Write the used speech in the format of the released loader");
  command.add_flag("--heard", generation.write_heard,
                   "Write the sound of every speaker at every viewpoint, too");
  command.add_option("--jobs", options.what.jobs, "Threads; 0 takes all cores")
      ->capture_default_str();
  command.add_option("--shard", options.what.shard, "Make only the i-th of n parts: i/n, from 0");
  command.add_flag("--quiet", options.quiet, "No progress, no summary");
  command.add_flag("--json", options.json, "Print the summary as JSON");
}

}  // namespace

void add_simulate_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "simulate",
      "Simulate a data set: homes, people who talk in them, pictures and binaural responses.");
  command
      ->add_option("--out", options->what.generation.folder,
                   "Folder of the data set; an interrupted run continues there")
      ->required();
  add_what(*command, *options);
  add_how(*command, *options);
  command->callback([options] { run(*options); });
}

}  // namespace earpoint

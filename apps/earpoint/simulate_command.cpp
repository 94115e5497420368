#include "simulate_command.h"

#include "flag_advice.h"
#include "flag_checks.h"
#include "simulate_report.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/core/parallel.h>
#include <earpoint/core/progress.h>
#include <earpoint/error.h>
#include <earpoint/generate/generation.h>
#include <earpoint/generate/scene_maker.h>
#include <earpoint/scene/material_table.h>
#include <earpoint/scene/model_pack.h>

namespace {

namespace fs = std::filesystem;
using earpoint::InputError;

struct Options {
  earpoint::GenerationOptions generation;
  std::vector<fs::path> scenes;
  std::optional<fs::path> materials;
  std::optional<fs::path> speech;
  std::string up_axis;
  double unit_m = 1.0;
  std::string split;
  std::string shard;
  int jobs = 0;
  bool close_ceiling = false;
  bool released_speech = false;
  bool quiet = false;
  bool json = false;
};

void check_at_least(const char* flag, double value, double least) {
  if (value >= least) return;
  throw InputError(flag, fmt::format("expected {:g} or more, found {:g}", least, value));
}

void check_within(const char* flag, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw InputError(flag, fmt::format("expected {:g} to {:g}, found {:g}", least, most, value));
}

void check(const Options& options) {
  const earpoint::GenerationOptions& generation = options.generation;
  check_at_least("--scenes", generation.order.scenes, 1);
  check_at_least("--conversations", generation.order.conversations, 1);
  check_at_least("--viewpoints", generation.conversation.viewpoints, 2);
  check_within("--other-rooms", generation.conversation.other_room_share, 0.0, 1.0);
  check_within("--other-rooms-reach", generation.conversation.other_room_reach_m, 1.0, 100.0);
  check_within("--height-spread", generation.conversation.height_spread_m, 0.0, 1.0);
  check_at_least("--rays", generation.quality.rays, 1);
  check_at_least("--rate", generation.quality.sample_rate_hz, 8000);
  check_at_least("--jobs", options.jobs, 0);
  if (!(generation.quality.duration_s > 0.0 && generation.quality.duration_s <= 30.0)) {
    throw InputError("--duration", fmt::format("expected more than 0 and at most 30 s, found {:g}",
                                               generation.quality.duration_s));
  }
  if (options.split.find_first_of("/\\") != std::string::npos || options.split.starts_with('.')) {
    throw InputError("--split", "expected a folder's name, found '" + options.split + "'");
  }
  if (!options.scenes.empty()) return;
  const auto refuse = [](const char* flag) {
    throw InputError(flag, "applies only to a scene that is read from a file",
                     "give one with --scene");
  };
  if (options.materials) refuse("--materials");
  if (!options.up_axis.empty()) refuse("--up");
  if (options.unit_m != 1.0) refuse("--unit");
  if (options.close_ceiling) refuse("--close-ceiling");
}

std::unique_ptr<earpoint::SceneMaker> scene_maker(const Options& options,
                                                  earpoint::ModelPack& models,
                                                  const earpoint::MaterialTable* materials,
                                                  std::string_view materials_text,
                                                  earpoint::StreamProgress& bar) {
  if (options.scenes.empty()) {
    return std::make_unique<earpoint::HomeMaker>(
        options.generation.seed, earpoint::FurnitureLibrary(std::move(models.furniture)));
  }
  earpoint::ImportOptions import{
      .unit_m = options.unit_m, .materials = materials, .close_ceiling = options.close_ceiling};
  if (!options.up_axis.empty()) {
    import.up_axis = options.up_axis == "y" ? earpoint::UpAxis::y : earpoint::UpAxis::z;
  }
  const auto warn = [&bar](const fs::path& file, const std::string& warning) {
    bar.note(fmt::format("earpoint: {}: {}", file.string(), with_flags(warning)));
  };
  return std::make_unique<earpoint::FileSceneMaker>(options.scenes, import, materials_text, warn);
}

void run(Options options) {
  if (!options.scenes.empty()) {
    options.generation.order.scenes = static_cast<int>(options.scenes.size());
  }
  check(options);
  earpoint::GenerationOptions& generation = options.generation;
  if (!options.split.empty()) generation.order.split = options.split;
  if (!options.shard.empty()) generation.shard = earpoint::parse_shard(options.shard);
  if (options.released_speech) generation.speech_form = earpoint::SpeechForm::released;
  generation.jobs = options.jobs > 0 ? options.jobs : earpoint::available_cores();

  const earpoint::SpeechCorpus corpus =
      earpoint::SpeechCorpus::load(options.speech.value_or(earpoint::default_speech_folder()));
  std::optional<earpoint::MaterialTable> materials;
  std::string materials_text;
  if (options.materials) {
    materials_text = earpoint::read_text_file(*options.materials);
    materials = earpoint::MaterialTable::parse(materials_text, options.materials->string());
  }
  earpoint::ModelPack models = earpoint::installed_models();
  earpoint::StreamProgress bar(stderr);
  const std::unique_ptr<earpoint::SceneMaker> scenes =
      scene_maker(options, models, materials ? &*materials : nullptr, materials_text, bar);
  const earpoint::FigureLibrary figures(std::move(models.figures));

  earpoint::SilentProgress silent;
  earpoint::ProgressSink& progress =
      options.quiet ? static_cast<earpoint::ProgressSink&>(silent) : bar;
  const earpoint::GenerationSummary summary =
      generate_dataset(generation, *scenes, figures, corpus, progress);
  if (options.json) {
    fmt::print("{}", json_of(summary));
  } else if (!options.quiet) {
    fmt::print("{}", simulation_report(summary));
  }
}

void add_what(CLI::App& command, Options& options) {
  earpoint::WorkOrder& order = options.generation.order;
  command
      .add_option(
          "--scenes", order.scenes,
          "Number of homes, split 90 : 10 : 20 into train, val and test; with a single home "
          "its conversations are split instead")
      ->capture_default_str();
  command
      .add_option("--scene", options.scenes,
                  "Scans or models of your own instead (.glb, .gltf, .obj, .ply)")
      ->excludes("--scenes");
  command.add_option(
      "--materials", options.materials,
      "Acoustic materials of the surfaces of --scene (JSON); default: the standard table");
  command.add_option("--up", options.up_axis, "Axis that points up in --scene")
      ->check(CLI::IsMember({"y", "z"}));
  command.add_option("--unit", options.unit_m, "Length of the unit of --scene, metres");
  command.add_flag("--close-ceiling", options.close_ceiling,
                   "Add a ceiling to --scene where it has none");
  command.add_option("--conversations", order.conversations, "Conversations in each scene")
      ->capture_default_str();
  command.add_option("--split", options.split, "Put everything into this split");
  command.add_option("--speech", options.speech,
                     "Folder of recorded speech: LibriSpeech, or with a speech.csv (file, speaker, "
                     "gender); default: what ./dev speech gathers");
}

void add_how(CLI::App& command, Options& options) {
  earpoint::GenerationOptions& generation = options.generation;
  command.add_option("--seed", generation.seed, "The same seed gives the same bytes")
      ->check(whole_number())
      ->capture_default_str();
  command
      .add_option("--viewpoints", generation.conversation.viewpoints,
                  "Viewpoints of each conversation")
      ->capture_default_str();
  command
      .add_option(
          "--other-rooms", generation.conversation.other_room_share,
          "Share of the viewpoints, except the first of a conversation, in other rooms without "
          "sight of the speakers")
      ->capture_default_str();
  command
      .add_option("--other-rooms-reach", generation.conversation.other_room_reach_m,
                  "Largest distance of those from the speakers, metres")
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
  command.add_flag("--released-speech", options.released_speech,
                   "Write the used speech in the format of the released loader");
  command.add_flag("--heard", generation.write_heard,
                   "Write the sound of every speaker at every viewpoint, too");
  command.add_option("--jobs", options.jobs, "Threads; 0 takes all cores")->capture_default_str();
  command.add_option("--shard", options.shard, "Make only the i-th of n parts: i/n, from 0");
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
      ->add_option("--out", options->generation.folder,
                   "Folder of the data set; an interrupted run continues there")
      ->required();
  add_what(*command, *options);
  add_how(*command, *options);
  command->callback([options] { run(*options); });
}

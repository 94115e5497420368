#include "simulate_run.h"

#include <memory>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/scene/material_table.h>
#include <earpoint/scene/model_pack.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

void check_at_least(const char* flag, double value, double least) {
  if (value >= least) return;
  throw InputError(flag, fmt::format("expected {:g} or more, found {:g}", least, value));
}

void check_within(const char* flag, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw InputError(flag, fmt::format("expected {:g} to {:g}, found {:g}", least, most, value));
}

void check(const SimulateOptions& options) {
  const GenerationOptions& generation = options.generation;
  check_at_least("--scenes", generation.order.scenes, 1);
  check_at_least("--conversations", generation.order.conversations, 1);
  check_at_least("--viewpoints", generation.conversation.viewpoints, 2);
  check_within("--reach", generation.conversation.viewpoint_reach_m, 1.0, 100.0);
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
  if (!options.up_axis.empty() && options.up_axis != "y" && options.up_axis != "z") {
    throw InputError("--up", "expected y or z, found '" + options.up_axis + "'");
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

std::unique_ptr<SceneMaker> scene_maker(const SimulateOptions& options, ModelPack& models,
                                        const MaterialTable* materials,
                                        std::string_view materials_text,
                                        const FileSceneMaker::Warn& warn) {
  if (options.scenes.empty()) {
    return std::make_unique<HomeMaker>(options.generation.seed,
                                       FurnitureLibrary(std::move(models.furniture)));
  }
  ImportOptions import{
      .unit_m = options.unit_m, .materials = materials, .close_ceiling = options.close_ceiling};
  if (!options.up_axis.empty()) {
    import.up_axis = options.up_axis == "y" ? UpAxis::y : UpAxis::z;
  }
  return std::make_unique<FileSceneMaker>(options.scenes, import, materials_text, warn);
}

}  // namespace

GenerationSummary simulate(SimulateOptions options, const FileSceneMaker::Warn& warn,
                           ProgressSink& progress) {
  if (!options.scenes.empty()) {
    options.generation.order.scenes = static_cast<int>(options.scenes.size());
  }
  check(options);
  GenerationOptions& generation = options.generation;
  if (!options.split.empty()) generation.order.split = options.split;
  if (!options.shard.empty()) generation.shard = parse_shard(options.shard);
  if (options.released_speech) generation.speech_form = SpeechForm::released;
  generation.jobs = options.jobs > 0 ? options.jobs : available_cores();

  const SpeechCorpus corpus = SpeechCorpus::load(options.speech.value_or(default_speech_folder()));
  std::optional<MaterialTable> materials;
  std::string materials_text;
  if (options.materials) {
    materials_text = read_text_file(*options.materials);
    materials = MaterialTable::parse(materials_text, options.materials->string());
  }
  ModelPack models = installed_models();
  const std::string lack = warning_of(models);
  if (options.scenes.empty() && !lack.empty()) warn("homes", lack);
  const std::unique_ptr<SceneMaker> scenes =
      scene_maker(options, models, materials ? &*materials : nullptr, materials_text, warn);
  const FigureLibrary figures(std::move(models.figures));
  return generate_dataset(generation, *scenes, figures, corpus, progress);
}

}  // namespace earpoint

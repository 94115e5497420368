#include "evaluate_set.h"

#include <cmath>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <earpoint/dataset/pair_list.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>

namespace earpoint {
namespace {

constexpr std::size_t kCacheBytes = std::size_t{512} << 20U;
// As in the training configurations for enhancement.
constexpr double kUsualAmbientDb = -40.0;

std::ptrdiff_t context_of(const EvaluateOptions& options) {
  return std::lround(options.context_s * kMetricRateHz);
}

std::unique_ptr<EvaluationSet> recorded_set(const EvaluateOptions& options) {
  if (options.context_s > 0.0) {
    throw InputError("--context", "clips of Replay-NVAS are used whole", "leave it out");
  }
  if (!options.ambient.empty()) {
    throw InputError("--ambient", "recordings have their own ambient sound",
                     "leave it out, or use simulated data");
  }
  if (options.pairs) {
    throw InputError("--pairs",
                     "Replay-NVAS has no pair lists; its pairs are drawn as the released "
                     "test draws them",
                     "leave it out");
  }
  if (options.draw == "every-target") {
    throw InputError("--draw every-target", "Replay-NVAS is drawn as the released test draws it",
                     "leave it out");
  }
  return replay_evaluation_set(options.data, options.split, options.limit, target_of(options));
}

std::unique_ptr<EvaluationSet> rwavs_set(const EvaluateOptions& options) {
  const auto refuse = [](const char* flag, const char* why) {
    throw InputError(flag, why, "leave it out");
  };
  if (options.split != "train" && options.split != "val") {
    throw InputError("--split " + options.split, "RWAVS has train and val", "use --split val");
  }
  if (options.enhance) refuse("--enhance", "RWAVS has no microphones close to mouths");
  if (options.context_s > 0.0) refuse("--context", "RWAVS is measured second by second");
  if (!options.ambient.empty()) refuse("--ambient", "RWAVS has its own ambient sound");
  if (options.pairs) refuse("--pairs", "RWAVS has no pairs: every pose of a split is measured");
  if (!options.draw.empty()) refuse("--draw", "RWAVS has no pairs: every pose is measured");
  if (options.report) refuse("--report", "RWAVS has no source view to show");
  if (options.boxes != "true") refuse("--boxes", "RWAVS has no picture of the loudspeaker");
  return rwavs_evaluation_set(options.data, options.split, options.limit);
}

}  // namespace

PairTarget target_of(const EvaluateOptions& options) {
  return options.enhance ? PairTarget::near_microphone : PairTarget::viewpoint;
}

EvaluateAmbient ambient_of(const EvaluateOptions& options) {
  EvaluateAmbient ambient;
  // Recordings have their own.
  const bool is_simulated = layout_of(options) == DatasetLayout::soundspaces;
  if (is_simulated && (options.enhance || !options.ambient.empty())) {
    ambient.level_db = kUsualAmbientDb;
  }
  for (const std::string& word : options.ambient) {
    if (const auto separation = ambient_separation_named(word)) {
      ambient.separation = *separation;
      continue;
    }
    double level_db = 0.0;
    if (!CLI::detail::lexical_cast(word, level_db) || !(level_db >= -120.0 && level_db <= 0.0)) {
      throw InputError("--ambient",
                       fmt::format("expected a level from -120 to 0 or one of {}, found '{}'",
                                   fmt::join(ambient_separation_names(), ", "), word));
    }
    ambient.level_db = level_db;
  }
  return ambient;
}

DatasetLayout layout_of(const EvaluateOptions& options) {
  std::optional<DatasetLayout> asked;
  if (!options.layout.empty()) asked = layout_named(options.layout);
  return dataset_layout(options.data, asked);
}

std::unique_ptr<EvaluationSet> evaluation_set(const EvaluateOptions& options) {
  if (layout_of(options) == DatasetLayout::replay) {
    return recorded_set(options);
  }
  if (layout_of(options) == DatasetLayout::rwavs) return rwavs_set(options);
  PairChoice pairs{.list = options.pairs, .draw = std::nullopt};
  if (!options.draw.empty()) pairs.draw = draw_named(options.draw);
  auto set = soundspaces_evaluation_set(options.data, options.split, pairs, options.limit,
                                        kCacheBytes, target_of(options), context_of(options));
  const EvaluateAmbient ambient = ambient_of(options);
  return ambient.level_db ? with_ambient(std::move(set), *ambient.level_db, ambient.separation)
                          : std::move(set);
}

}  // namespace earpoint

#include "description_section.h"
#include "task_kinds.h"

#include <initializer_list>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/strict_json.h>
#include <earpoint/dataset/ambient.h>
#include <earpoint/error.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/training_range.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/rt60/description.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/train/gtf_learner.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

/// @param weights  for keys that `json` lacks
GtfLossWeights loss_from(const Json& json, const std::string& where, GtfLossWeights weights) {
  constexpr double kMost = 1000.0;
  JsonObjectReader reader(json, where);
  for (const auto& [key, weight] : std::initializer_list<std::pair<const char*, double*>>{
           {"log_magnitude", &weights.log_magnitude},
           {"level_difference", &weights.level_difference},
           {"level", &weights.level},
           {"squared_level", &weights.squared_level},
           {"modulation", &weights.modulation},
           {"decay", &weights.decay},
           {"reverberation", &weights.reverberation},
           {"phase_difference", &weights.phase_difference},
           {"dry_voice", &weights.dry_voice},
           {"place", &weights.place}}) {
    if (!reader.has(key)) continue;
    *weight = reader.number(key);
    if (*weight >= 0.0 && *weight <= kMost) continue;
    throw InputError(where, fmt::format("'{}': expected 0 to {}, found {}", key, kMost, *weight));
  }
  reader.expect_nothing_else();
  return weights;
}

/// The parts of a network's section besides its description.
struct GtfStart {
  GtfLossWeights loss;
  std::optional<GtfLossWeights> natural_loss;
  std::optional<std::string> init;        ///< a weight file to start from
  std::optional<std::string> estimator;   ///< the weight file of one of reverberation time
  std::optional<GtfTrainingRange> range;  ///< of the data; nothing: as in the weights
  std::int64_t place_steps = 0;
};

/// Takes the path at `key` out of the network's section. @param what  it is the path of
std::optional<std::string> take_path(Json& section, const char* key, const char* what,
                                     const std::string& where) {
  if (!section.contains(key)) return std::nullopt;
  if (!section[key].is_string()) {
    throw InputError(where, fmt::format("'{}': expected the path of {}", key, what));
  }
  std::string path = section[key];
  section.erase(key);
  return path;
}

/// Takes `place_steps` out of the network's section. @param place  weight of that loss
std::int64_t take_place_steps(Json& section, double place, const std::string& where) {
  if (!section.contains("place_steps")) return 0;
  const Json& steps = section["place_steps"];
  if (!steps.is_number_integer() || steps.get<std::int64_t>() < 0) {
    throw InputError(where, "'place_steps': expected a whole number, 0 or more");
  }
  const auto count = steps.get<std::int64_t>();
  if (count > 0 && place == 0.0) {
    throw InputError(where, "'place_steps' needs the loss of the position",
                     "set 'loss.place' to more than 0");
  }
  section.erase("place_steps");
  return count;
}

/// Takes `loss`, `init`, `estimator`, `training_range` and `place_steps` out of the network's
/// section.
GtfStart take_start(std::string& section, const std::string& where) {
  constexpr int kDepth = 3;  // the section, its loss, that of the natural texture
  GtfStart start;
  Json json = parse_strict_json(section, where, kDepth);
  if (!json.is_object()) return start;
  if (json.contains("loss")) {
    Json& loss = json["loss"];
    const std::string of_natural = fmt::format("{}: 'loss': 'natural'", where);
    std::optional<Json> natural;
    if (loss.is_object() && loss.contains("natural")) {
      natural = loss["natural"];
      loss.erase("natural");
    }
    start.loss = loss_from(loss, fmt::format("{}: 'loss'", where), {});
    if (natural) start.natural_loss = loss_from(*natural, of_natural, start.loss);
  }
  json.erase("loss");
  start.init = take_path(json, "init", "weights", where);
  if (json.contains("training_range")) {
    start.range = gtf_training_range_from_json(json["training_range"].dump(),
                                               fmt::format("{}: 'training_range'", where));
    json.erase("training_range");
  }
  start.estimator = take_path(json, "estimator", "an rt60 network's weights", where);
  start.place_steps = take_place_steps(json, start.loss.place, where);
  const bool is_heard =
      start.loss.reverberation > 0 || (start.natural_loss && start.natural_loss->reverberation > 0);
  if (is_heard != start.estimator.has_value()) {
    throw InputError(where, "'loss.reverberation' and 'estimator' need each other",
                     "give both or none");
  }
  section = json.dump();
  return start;
}

GtfLearner make_learner(const GtfDescription& description, const GtfLearnerOptions& learner,
                        const std::optional<std::string>& init, std::uint64_t seed,
                        const TaskOptions& options) {
  if (options.device != "cpu") {
    throw InputError("device " + options.device, "this network is trained on the processor only",
                     "use cpu");
  }
  if (options.checkpoint != nullptr) {
    return GtfLearner::from_checkpoint(*options.checkpoint, "the checkpoint", learner);
  }
  if (init) {
    GtfWeights weights = gtf_weights(read_safetensors(*init), *init);
    // The cut-off describes the sounds that a network was trained on, and these may be others.
    weights.description.highpass_cutoff_hz = description.highpass_cutoff_hz;
    return GtfLearner(with_new_parts(std::move(weights), description, seed), learner);
  }
  const HrtfSet head = HrtfSet::load(GtfDescription::kSampleRateHz);
  return GtfLearner(initial_gtf_weights(description, head, seed), learner);
}

}  // namespace

TrainingTask gtf_task(const TrainConfig& config, std::string_view where,
                      const TaskOptions& options) {
  PairOptions pairs = pair_options(config, where, options);
  const std::string network = fmt::format("{}: 'network'", where);
  std::string section = config.network;
  GtfLearnerOptions learner_options;
  const GtfStart start = take_start(section, network);
  learner_options.loss = start.loss;
  learner_options.natural_loss = start.natural_loss;
  learner_options.training_range = start.range;
  learner_options.place_steps = start.place_steps;
  if (start.estimator) {
    learner_options.estimator =
        rt60_estimator_weights(read_safetensors(*start.estimator), *start.estimator);
    if (pairs.samples < Rt60Description::kWindowSamples) {
      throw InputError(where,
                       fmt::format("'loss.reverberation' needs windows of {} samples or more",
                                   Rt60Description::kWindowSamples));
    }
  }
  GtfDescription usual;
  if (pairs.separate) usual.highpass_cutoff_hz = kSeparationCutoffHz;
  if (pairs.layout == DatasetLayout::replay) usual.highpass_cutoff_hz = kReplayCutoffHz;
  usual.window_samples = static_cast<int>(pairs.samples);
  GtfDescription description =
      gtf_description_from_json(description_with(section, to_json(usual), network), network);
  if (start.range) description.training_range = *start.range;
  if (description.texture != start.natural_loss.has_value()) {
    throw InputError(network, "'texture' and 'loss.natural' need each other", "give both or none");
  }
  if (start.place_steps > 0 && !description.geometry) {
    throw InputError(network, "'place_steps' needs a network that locates the speaker",
                     "set 'geometry' to true");
  }
  if (start.loss.dry_voice > 0 && !description.dry_voice) {
    throw InputError(network, "'loss.dry_voice' needs a network with that output",
                     "set 'dry_voice' to true");
  }
  pairs.near_voice = description.dry_voice || start.loss.decay > 0 ||
                     (start.natural_loss && start.natural_loss->decay > 0);
  TrainingTask task;
  auto learner = std::make_unique<GtfLearner>(
      make_learner(description, learner_options, start.init, config.training.seed, options));
  if (!start.range) description.training_range = learner->description().training_range;
  const auto encode = [description](const PairSample& sample) {
    return gtf_example(description, sample);
  };
  task.examples = pair_examples(std::move(pairs), encode);
  if (learner->description() != description) {
    throw InputError(where, "describes a different network from the weights it starts from");
  }
  task.learner = std::move(learner);
  return task;
}

}  // namespace earpoint

#include <earpoint/train/training_task.h>

#include "task_kinds.h"
#include "vigas/conditioning_probe.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/network/picture_planes.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/vigas_learner.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {
namespace {

/// Smallest distance from mouth to ear.
constexpr double kNearest_m = 0.25;

ViGasWeights starting_weights(const ViGasConfig& config, std::uint64_t seed,
                              std::string_view where) {
  ViGasWeights weights;
  switch (config.start) {
    case ViGasStart::released:
      weights = initial_vigas_weights(config.description, seed);
      break;
    case ViGasStart::identity:
      weights = identity_vigas_weights(config.description, seed);
      break;
    case ViGasStart::file:
      weights = read_vigas_weights(config.start_file);
      // The cut-off describes the sounds that a network was trained on, and these may be others.
      weights.description.highpass_cutoff_hz = config.description.highpass_cutoff_hz;
      if (to_json(weights.description) != to_json(config.description)) {
        throw InputError(where, fmt::format("'init': {} belongs to a different network",
                                            config.start_file.string()));
      }
      break;
  }
  if (config.trunk) load_image_trunk(*config.trunk, weights);
  return weights;
}

std::unique_ptr<Learner> vigas_learner(const ViGasConfig& config, std::uint64_t seed,
                                       std::string_view where, const TaskOptions& options) {
  const LearnerOptions learner_options{.loss = config.loss,
                                       .place = config.place,
                                       .place_steps = config.place_steps,
                                       .device = options.device};
  if (options.checkpoint == nullptr) {
    return std::make_unique<ViGasLearner>(starting_weights(config, seed, where), learner_options);
  }
  auto learner = std::make_unique<ViGasLearner>(
      ViGasLearner::from_checkpoint(*options.checkpoint, "the checkpoint", learner_options));
  if (to_json(learner->description()) != to_json(config.description)) {
    throw InputError(where, "describes a different network from the checkpoint");
  }
  return learner;
}

TrainingTask vigas_task(const TrainConfig& config, std::string_view where,
                        const TaskOptions& options) {
  PairOptions pairs = pair_options(config, where, options);
  ViGasConfig network =
      vigas_config_from_json(config.network, fmt::format("{}: 'network'", where), pairs.separate);
  if (pairs.layout == DatasetLayout::replay) {
    network.description.highpass_cutoff_hz = kReplayCutoffHz;
    if (network.place > 0.0) {
      throw InputError(where, "'network': 'place': recordings do not have the speaker's position",
                       "leave it out");
    }
  }
  TrainingTask task;
  const auto encode = [description = network.description](const PairSample& sample) {
    return vigas_example(description, sample);
  };
  task.examples = pair_examples(std::move(pairs), encode);
  task.learner = vigas_learner(network, config.training.seed, where, options);
  return task;
}

/// Targets of ConditioningProbe: cosine and sine of the speaker's azimuth at the target, logarithm
/// of the distance there in metres, and its difference to the source.
std::vector<float> place_of(const PairSample& sample) {
  const Spherical seen = spherical_from_cartesian(
      transform_point(inverse(sample.source_from_target), sample.speaker_m));
  const double azimuth_rad = seen.azimuth_rad;
  const double target_m = std::max(seen.distance_m, kNearest_m);
  const double source_m = std::max(norm(sample.speaker_m), kNearest_m);
  return {static_cast<float>(std::cos(azimuth_rad)), static_cast<float>(std::sin(azimuth_rad)),
          static_cast<float>(std::log(target_m)),
          static_cast<float>(std::log(target_m / source_m))};
}

std::vector<float> planar(const Waveform& sound) {
  return {sound.planar().begin(), sound.planar().end()};
}

}  // namespace

PairOptions pair_options(const TrainConfig& config, std::string_view where,
                         const TaskOptions& options) {
  PairOptions pairs = pair_options_from_json(config.data, fmt::format("{}: 'data'", where));
  pairs.data = options.data;
  pairs.more_data = options.more_data;
  pairs.layout = dataset_layout(options.data, options.layout);
  pairs.seed = config.training.seed;
  pairs.cache_bytes = options.cache_bytes;
  pairs.on_bad = options.on_bad;
  return pairs;
}

TrainingTask make_training_task(const TrainConfig& config, std::string_view where,
                                const TaskOptions& options) {
  const bool learns_pairs = config.kind != "rt60" && config.kind != "people";
  if (!learns_pairs && !options.more_data.empty()) {
    throw InputError(options.more_data.front().string(),
                     "a network of this kind is trained on one folder only", "give one folder");
  }
  if (config.kind == "vigas") return vigas_task(config, where, options);
  if (config.kind == "gtf") return gtf_task(config, where, options);
  if (config.kind == "vam") return vam_task(config, where, options);
  if (config.kind == "rt60") return rt60_task(config, where, options);
  if (config.kind == "people") return people_task(config, where, options);
  throw InputError(
      where,
      fmt::format(
          R"('network': 'kind': expected "vigas", "gtf", "vam", "rt60" or "people", found "{}")",
          config.kind));
}

TrainingExample vigas_example(const ViGasDescription& description, const PairSample& sample) {
  TrainingExample example;
  example.source = planar(sample.source);
  example.target = planar(sample.target);
  if (const auto& encoder = description.image_encoder) {
    example.picture = picture_planes(*sample.picture, encoder->width_px, encoder->height_px);
  }
  EncodedPose pose =
      encode_pose(description.pose_encoding, sample.source_from_target, sample.world_from_source);
  example.inputs["tgt_pose"] = std::move(pose.tgt_pose);
  example.inputs["tgt_rotation"] = std::move(pose.tgt_rotation);
  if (description.has_input("bboxes")) {
    example.inputs["bboxes"] = encode_box(description.box_encoding, sample.speaker_box);
  }
  example.inputs[ConditioningProbe::kPlace] = place_of(sample);
  return example;
}

}  // namespace earpoint

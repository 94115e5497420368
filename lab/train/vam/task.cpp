#include "description_section.h"
#include "task_kinds.h"

#include <utility>

#include <fmt/format.h>

#include <earpoint/dataset/ambient.h>
#include <earpoint/error.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/vam_learner.h>
#include <earpoint/vam/description.h>

namespace earpoint {

TrainingTask vam_task(const TrainConfig& config, std::string_view where,
                      const TaskOptions& options) {
  PairOptions pairs = pair_options(config, where, options);
  const std::string network = fmt::format("{}: 'network'", where);
  VamDescription usual;
  if (pairs.separate) usual.highpass_cutoff_hz = kSeparationCutoffHz;
  if (pairs.layout == DatasetLayout::replay) usual.highpass_cutoff_hz = kReplayCutoffHz;
  const VamDescription description =
      vam_description_from_json(description_with(config.network, to_json(usual), network), network);
  TrainingTask task;
  const auto encode = [description](const PairSample& sample) {
    return vam_example(description, sample);
  };
  task.examples = pair_examples(std::move(pairs), encode);
  auto learner = std::make_unique<VamLearner>(
      options.checkpoint == nullptr
          ? VamLearner(initial_vam_weights(description, config.training.seed), options.device)
          : VamLearner::from_checkpoint(*options.checkpoint, "the checkpoint", options.device));
  if (to_json(learner->description()) != to_json(description)) {
    throw InputError(where, "describes a different network from the checkpoint");
  }
  task.learner = std::move(learner);
  return task;
}

}  // namespace earpoint

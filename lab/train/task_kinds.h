#pragma once

#include <string_view>

#include <earpoint/train/training_task.h>

namespace earpoint {

/// The `data` section of a network that learns pairs of viewpoints, and what the run adds to it.
PairOptions pair_options(const TrainConfig& config, std::string_view where,
                         const TaskOptions& options);

/// make_training_task() for one kind of network each: "gtf", "rt60", "vam" and "people". Their
/// sections hold what the network's description (docs/formats.md) has, where it is not the default.
/// That of "gtf" also has a `loss`, whose keys are the terms of GtfLossWeights, an `init` to start
/// from and, for the term `reverberation`, the path of an `estimator`.
TrainingTask gtf_task(const TrainConfig& config, std::string_view where,
                      const TaskOptions& options);
TrainingTask rt60_task(const TrainConfig& config, std::string_view where,
                       const TaskOptions& options);
TrainingTask vam_task(const TrainConfig& config, std::string_view where,
                      const TaskOptions& options);
TrainingTask people_task(const TrainConfig& config, std::string_view where,
                         const TaskOptions& options);

}  // namespace earpoint

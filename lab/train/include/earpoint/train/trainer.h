#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/core/range_lock.h>
#include <earpoint/train/example_loader.h>
#include <earpoint/train/learner.h>
#include <earpoint/train/process_group.h>
#include <earpoint/train/train_config.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// Why training ended.
enum class TrainingEnd { steps, minutes, patience };
[[nodiscard]] std::string_view name_of(TrainingEnd end);

/// How a run went, those before an interruption included.
struct TrainingSummary {
  std::int64_t steps = 0;
  std::int64_t clips = 0;
  double seconds = 0.0;      ///< of training, without validation
  double clips_per_s = 0.0;  ///< of all processes together
  std::string error_name;    ///< of the learner's metric
  double best_error = 0.0;   ///< mean over the validation examples
  std::int64_t best_step = 0;
  double first_error = 0.0;  ///< before the first step
  TrainingEnd end = TrainingEnd::steps;
};

/// The result of a validation.
struct ValidationResult {
  std::int64_t step = 0;
  std::int64_t clips = 0;
  double seconds = 0.0;
  double loss = 0.0;   ///< mean over the steps since the last one; 0 before the first step
  double error = 0.0;  ///< mean over the validation examples
  bool is_best = false;
};

struct TrainerOptions {
  std::filesystem::path folder;  ///< of the run; is made
  TrainingPlan plan;
  std::string config;          ///< kept as config.json
  int workers = 1;             ///< threads that make examples
  double save_every_s = 60.0;  ///< least time between checkpoints, those of validations apart
  /// Those that learn together, or null. All must have the same plan and start with the same
  /// learner; the first alone writes into the folder.
  ProcessGroup* processes = nullptr;
  std::function<void(const ValidationResult&)> on_validation;
};

/// Keeps other processes out of a run's folder as long as it lives, or its process does.
class RunLock {
 public:
  /// Makes the folder if it is not there.
  /// @throws InputError if another process trains there or it cannot be written
  explicit RunLock(const std::filesystem::path& folder);

 private:
  RangeLock lock_;
};

/// Trains, and keeps in the run's folder
/// - `config.json`: what it was told;
/// - `checkpoint.safetensors`: everything that it goes on from after a kill, written every minute
///   (TrainerOptions::save_every_s) and with every validation: weights, optimizer, step, best
///   error; random draws depend on seed and step alone;
/// - `best.safetensors`: the weights with the lowest validation error so far, ready to use;
/// - `steps.csv`, `validation.csv`, `curves.png`: how it went.
/// Each is whole at any time. A run that was killed and is resumed has the losses of an unbroken
/// one, unless the clock decides (TrainingPlan::minutes).
///
/// Of several processes each takes its share of every step's clips, and the gradients are averaged:
/// but for rounding a step is that of one process with all clips, if the loss is a mean over clips
/// and the network has no batch norm. Batch norms see the process's own share; their running
/// statistics are averaged.
///
/// @param checkpoint  of a run to go on with, as read_checkpoint() gives it; the learner is the one
///                    that it holds
/// @throws InputError if the folder cannot be written, an example cannot be made, or another
///         process ends
TrainingSummary train(Learner& learner, const ExampleLoader& examples,
                      const TrainerOptions& options, const SafetensorsFile* checkpoint,
                      ProgressSink& progress);

/// @return nothing if the folder holds no run
/// @throws InputError if the folder's run is of another configuration: its length apart (steps,
///         minutes, patience), that must be the same
[[nodiscard]] std::optional<SafetensorsFile> read_checkpoint(const std::filesystem::path& folder,
                                                             const std::string& config);

}  // namespace earpoint

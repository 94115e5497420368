#pragma once

#include "training_log.h"

#include <cstdint>
#include <filesystem>
#include <string>

#include <earpoint/train/trainer.h>

namespace earpoint {

/// What a checkpoint holds beside the learner.
struct RunState {
  std::int64_t step = 0;
  double seconds = 0.0;       ///< in all
  double step_seconds = 0.0;  ///< without validation
  double first_error = 0.0;
  double best_error = 0.0;
  std::int64_t best_step = -1;
  std::int64_t validations_since_best = 0;
};

/// @throws InputError if the checkpoint is of no run
[[nodiscard]] RunState run_state_in(const SafetensorsFile& checkpoint);

/// The files of a run: logs, curves, best weights, checkpoint.
class RunFolder {
 public:
  /// Makes the folder; goes on with its logs after `last_step`.
  /// @param options  must outlive this
  /// @throws InputError if it cannot be written
  RunFolder(const TrainerOptions& options, std::int64_t last_step);

  void add_step(std::int64_t step, double loss, double learning_rate);
  void add_validation(const ValidationResult& result);

  /// Mean loss of the steps since the last validation; 0 before the first step.
  [[nodiscard]] double recent_loss() const;

  /// Logs first and the checkpoint last: whatever a kill leaves, the logs reach as far as it does.
  /// @param is_kept  the weights are to be best.safetensors
  void save(const Learner& learner, const RunState& state, bool is_kept);

 private:
  void draw_curves(const std::string& error_name) const;

  const TrainerOptions& options_;
  NumberLog steps_;
  NumberLog validations_;
};

}  // namespace earpoint

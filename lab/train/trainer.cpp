#include <earpoint/train/trainer.h>

#include "batch_queue.h"
#include "run_folder.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kValidationBatch = 8;
constexpr int kBatchesAhead = 4;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Combines the gradients of several processes. Without a group it does nothing.
class Exchange {
 public:
  Exchange(ProcessGroup* group, int clips) : group_(group) {
    if (group == nullptr || clips >= group->size()) return;
    throw InputError("'training': 'batch'", fmt::format("expected at least a clip for each of {} "
                                                        "processes, found {}",
                                                        group->size(), clips));
  }

  [[nodiscard]] int rank() const { return group_ != nullptr ? group_->rank() : 0; }
  [[nodiscard]] int size() const { return group_ != nullptr ? group_->size() : 1; }
  [[nodiscard]] bool is_first() const { return rank() == 0; }

  /// The first process's number, in all.
  [[nodiscard]] double from_first(double value) {
    if (group_ == nullptr) return value;
    if (!is_first()) value = 0.0;
    group_->sum(std::span(&value, 1));
    return value;
  }

  void sum(std::span<double> values) {
    if (group_ != nullptr) group_->sum(values);
  }

  /// Averages gradients and statistics over all clips of the step.
  /// @param share  of the step's clips that this process has
  void average(Learner& learner, double share) {
    if (group_ == nullptr) return;
    // In one message, as latency costs more than size.
    numbers_.clear();
    const auto take = [&](std::span<float> values) {
      for (const float value : values) numbers_.push_back(value * static_cast<float>(share));
    };
    learner.visit_gradients(take);
    learner.visit_statistics(take);
    group_->sum(std::span(numbers_));
    auto next = numbers_.cbegin();
    const auto put = [&](std::span<float> values) {
      std::copy_n(next, values.size(), values.begin());
      next += std::ssize(values);
    };
    learner.visit_gradients(put);
    learner.visit_statistics(put);
    EARPOINT_CHECK(next == numbers_.cend());
  }

 private:
  ProcessGroup* group_;
  std::vector<float> numbers_;
};

class Run {
 public:
  Run(Learner& learner, const ExampleLoader& examples, const TrainerOptions& options,
      const SafetensorsFile* checkpoint, ProgressSink& progress)
      : learner_(learner),
        examples_(examples),
        options_(options),
        plan_(options.plan),
        progress_(progress),
        exchange_(options.processes, options.plan.batch),
        state_(checkpoint != nullptr ? run_state_in(*checkpoint) : RunState{}),
        is_resumed_(checkpoint != nullptr),
        seconds_before_(state_.seconds) {
    EARPOINT_CHECK(learner.steps() == state_.step);
    if (exchange_.is_first()) files_.emplace(options, state_.step);
  }

  TrainingSummary go() {
    if (!is_resumed_) validate();
    const double clips = static_cast<double>((plan_.steps - state_.step) * plan_.batch);
    progress_.begin("training", std::max(clips, 0.0), "clips");
    std::optional<TrainingEnd> end = reached_end();
    if (!end) {
      BatchQueue batches(
          state_.step, [&](std::int64_t step) { return batch_of(step); }, options_.workers,
          kBatchesAhead);
      while (!end) {
        take_step(batches.take());
        end = reached_end();
        if (end || state_.step % plan_.validate_every == 0) {
          validate();
          if (!end) end = reached_end();
        } else if (files_ && seconds_since(saved_) >= options_.save_every_s) {
          save(false);
        }
      }
    }
    progress_.finish();
    return summary(*end);
  }

 private:
  /// This process's share of the step's clips.
  [[nodiscard]] TrainingBatch batch_of(std::int64_t step) const {
    std::vector<TrainingExample> examples;
    const int last = plan_.batch * (exchange_.rank() + 1) / exchange_.size();
    for (int i = plan_.batch * exchange_.rank() / exchange_.size(); i < last; ++i) {
      examples.push_back(examples_.training(static_cast<std::uint64_t>(step) * plan_.batch + i));
    }
    return join(examples);
  }

  /// The reason to stop, or nothing.
  [[nodiscard]] std::optional<TrainingEnd> reached_end() const {
    if (state_.step >= plan_.steps) return TrainingEnd::steps;
    if (plan_.minutes && state_.seconds >= 60.0 * *plan_.minutes) return TrainingEnd::minutes;
    if (plan_.patience > 0 && state_.validations_since_best >= plan_.patience) {
      return TrainingEnd::patience;
    }
    return std::nullopt;
  }

  /// Progress of the run, 0 to 1: by steps, or by the clock if that ends it earlier.
  [[nodiscard]] double run_progress() const {
    double part = static_cast<double>(state_.step) / static_cast<double>(plan_.steps);
    if (plan_.minutes) part = std::max(part, state_.seconds / (60.0 * *plan_.minutes));
    return std::min(part, 1.0);
  }

  void take_step(const TrainingBatch& batch) {
    const Clock::time_point start = Clock::now();
    const double rate = learning_rate_at(plan_, state_.step, run_progress());
    const double share = static_cast<double>(batch.clips) / plan_.batch;
    double loss = share * learner_.compute_gradients(batch);
    exchange_.sum(std::span(&loss, 1));
    if (!std::isfinite(loss)) {
      throw InputError(fmt::format("training, step {}", state_.step), "the loss is not finite",
                       "lower the learning rate");
    }
    exchange_.average(learner_, share);
    learner_.apply_gradients(rate);
    ++state_.step;
    if (files_) files_->add_step(state_.step, loss, rate);
    state_.step_seconds += seconds_since(start);
    read_clock();
    progress_.advance(static_cast<double>(plan_.batch));
  }

  /// All processes use the first one's clock, so that they end at the same step.
  void read_clock() {
    state_.seconds = exchange_.from_first(seconds_before_ + seconds_since(start_));
  }

  /// Mean error over the validation examples, whose batches the processes take in turn.
  [[nodiscard]] double validation_error() {
    const auto examples = static_cast<std::int64_t>(examples_.validations());
    const std::int64_t batches = (examples + kValidationBatch - 1) / kValidationBatch;
    BatchQueue queue(
        0,
        [&](std::int64_t turn) {
          const std::int64_t number = turn * exchange_.size() + exchange_.rank();
          std::vector<TrainingExample> found;
          const std::int64_t last = std::min(examples, (number + 1) * kValidationBatch);
          for (std::int64_t i = number * kValidationBatch; i < last; ++i) {
            auto example = examples_.validation(static_cast<std::size_t>(i));
            if (example) found.push_back(std::move(*example));
          }
          return found.empty() ? TrainingBatch{} : join(found);
        },
        options_.workers, kBatchesAhead);
    double sum = 0.0;
    std::int64_t count = 0;
    for (std::int64_t i = exchange_.rank(); i < batches; i += exchange_.size()) {
      const TrainingBatch batch = queue.take();
      if (batch.clips == 0) continue;
      for (const double error : learner_.errors(batch)) sum += error;
      count += batch.clips;
    }
    std::array<double, 2> all{sum, static_cast<double>(count)};
    exchange_.sum(all);
    if (all[1] == 0.0) throw InputError("validation", "no example can be made");
    return all[0] / all[1];
  }

  void validate() {
    ValidationResult result{.step = state_.step, .clips = state_.step * plan_.batch};
    result.error = validation_error();
    if (files_) result.loss = files_->recent_loss();
    if (state_.best_step < 0) state_.first_error = result.error;
    result.is_best = state_.best_step < 0 || result.error < state_.best_error;
    if (result.is_best) {
      state_.best_error = result.error;
      state_.best_step = state_.step;
      state_.validations_since_best = 0;
    } else {
      ++state_.validations_since_best;
    }
    read_clock();
    result.seconds = state_.seconds;
    if (files_) {
      files_->add_validation(result);
      save(result.is_best || plan_.keep == Keep::last);
    }
    if (options_.on_validation) options_.on_validation(result);
  }

  /// @param is_kept  the weights are to be best.safetensors
  void save(bool is_kept) {
    files_->save(learner_, state_, is_kept);
    saved_ = Clock::now();
  }

  [[nodiscard]] TrainingSummary summary(TrainingEnd end) const {
    TrainingSummary summary{.steps = state_.step,
                            .clips = state_.step * plan_.batch,
                            .seconds = state_.seconds,
                            .error_name = std::string(learner_.error_name()),
                            .best_error = state_.best_error,
                            .best_step = state_.best_step,
                            .first_error = state_.first_error,
                            .end = end};
    if (state_.step_seconds > 0.0) {
      summary.clips_per_s = static_cast<double>(summary.clips) / state_.step_seconds;
    }
    return summary;
  }

  Learner& learner_;
  const ExampleLoader& examples_;
  const TrainerOptions& options_;
  const TrainingPlan& plan_;
  ProgressSink& progress_;
  Exchange exchange_;
  RunState state_;
  bool is_resumed_;
  double seconds_before_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point saved_ = start_;
  std::optional<RunFolder> files_;  ///< of the first process
};

}  // namespace

std::string_view name_of(TrainingEnd end) {
  switch (end) {
    case TrainingEnd::steps:
      return "steps";
    case TrainingEnd::minutes:
      return "minutes";
    case TrainingEnd::patience:
      return "patience";
  }
  EARPOINT_CHECK(false);
}

TrainingSummary train(Learner& learner, const ExampleLoader& examples,
                      const TrainerOptions& options, const SafetensorsFile* checkpoint,
                      ProgressSink& progress) {
  return Run(learner, examples, options, checkpoint, progress).go();
}

}  // namespace earpoint

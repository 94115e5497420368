#include "batch_queue.h"
#include "training_log.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <malloc.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/train/trainer.h>
#include <earpoint/video/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr const char* kCheckpoint = "checkpoint.safetensors";
constexpr const char* kStateKey = "earpoint.training";
constexpr const char* kConfigKey = "earpoint.training_config";
constexpr std::int64_t kValidationBatch = 8;
constexpr int kBatchesAhead = 4;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

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

std::string text_of(const RunState& state) {
  return Json{{"step", state.step},
              {"seconds", state.seconds},
              {"step_seconds", state.step_seconds},
              {"first_error", state.first_error},
              {"best_error", state.best_error},
              {"best_step", state.best_step},
              {"validations_since_best", state.validations_since_best}}
      .dump();
}

RunState state_in(const SafetensorsFile& checkpoint) {
  const auto found = checkpoint.metadata.find(kStateKey);
  if (found == checkpoint.metadata.end()) {
    throw InputError(kCheckpoint, fmt::format("has no '{}'", kStateKey), "start a new run");
  }
  try {
    const Json json = Json::parse(found->second);
    return {.step = json.at("step"),
            .seconds = json.at("seconds"),
            .step_seconds = json.at("step_seconds"),
            .first_error = json.at("first_error"),
            .best_error = json.at("best_error"),
            .best_step = json.at("best_step"),
            .validations_since_best = json.at("validations_since_best")};
  } catch (const Json::exception&) {
    throw InputError(kCheckpoint, fmt::format("its '{}' is malformed", kStateKey),
                     "start a new run");
  }
}

class Run {
 public:
  Run(Learner& learner, const ExampleSource& examples, const TrainerOptions& options,
      const SafetensorsFile* checkpoint, ProgressSink& progress)
      : learner_(learner),
        examples_(examples),
        options_(options),
        plan_(options.plan),
        progress_(progress),
        state_(checkpoint != nullptr ? state_in(*checkpoint) : RunState{}),
        is_resumed_(checkpoint != nullptr),
        seconds_before_(state_.seconds),
        steps_log_(options.folder / "steps.csv", "step,loss,learning_rate", state_.step),
        validation_log_(options.folder / "validation.csv", "step,clips,seconds,loss,error",
                        state_.step) {
    EARPOINT_CHECK(learner.steps() == state_.step);
  }

  TrainingSummary go() {
    write_file(options_.folder / "config.json", options_.config);
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
        }
      }
    }
    progress_.finish();
    return summary(*end);
  }

 private:
  [[nodiscard]] TrainingBatch batch_of(std::int64_t step) const {
    std::vector<TrainingExample> examples;
    for (int i = 0; i < plan_.batch; ++i) {
      examples.push_back(examples_.training(static_cast<std::uint64_t>(step) * plan_.batch + i));
    }
    return join(examples);
  }

  /// Nothing, or why no further step is taken.
  [[nodiscard]] std::optional<TrainingEnd> reached_end() const {
    if (state_.step >= plan_.steps) return TrainingEnd::steps;
    if (plan_.minutes && state_.seconds >= 60.0 * *plan_.minutes) return TrainingEnd::minutes;
    if (plan_.patience > 0 && state_.validations_since_best >= plan_.patience) {
      return TrainingEnd::patience;
    }
    return std::nullopt;
  }

  /// Of the run, 0 to 1: by steps, or by the clock if that ends it earlier.
  [[nodiscard]] double run_progress() const {
    double part = static_cast<double>(state_.step) / static_cast<double>(plan_.steps);
    if (plan_.minutes) part = std::max(part, state_.seconds / (60.0 * *plan_.minutes));
    return std::min(part, 1.0);
  }

  void take_step(const TrainingBatch& batch) {
    const Clock::time_point start = Clock::now();
    const double rate = learning_rate_at(plan_, state_.step, run_progress());
    const double loss = learner_.compute_gradients(batch);
    if (!std::isfinite(loss)) {
      throw InputError(fmt::format("training, step {}", state_.step), "the loss is not finite",
                       "lower the learning rate");
    }
    learner_.apply_gradients(rate);
    ++state_.step;
    steps_log_.add({static_cast<double>(state_.step), loss, rate});
    state_.step_seconds += seconds_since(start);
    state_.seconds = seconds_before_ + seconds_since(start_);
    progress_.advance(static_cast<double>(plan_.batch));
  }

  /// Mean error over the validation examples.
  [[nodiscard]] double validation_error() {
    const auto examples = static_cast<std::int64_t>(examples_.validations());
    const std::int64_t batches = (examples + kValidationBatch - 1) / kValidationBatch;
    BatchQueue queue(
        0,
        [&](std::int64_t number) {
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
    for (std::int64_t i = 0; i < batches; ++i) {
      const TrainingBatch batch = queue.take();
      if (batch.clips == 0) continue;
      for (const double error : learner_.errors(batch)) sum += error;
      count += batch.clips;
    }
    if (count == 0) throw InputError("validation", "not one example can be made");
    return sum / static_cast<double>(count);
  }

  /// Mean loss of the steps since the last validation.
  [[nodiscard]] double recent_loss() const {
    const double since = validation_log_.rows().empty() ? 0.0 : validation_log_.rows().back()[0];
    double sum = 0.0;
    std::int64_t count = 0;
    const auto& rows = steps_log_.rows();
    for (auto row = rows.rbegin(); row != rows.rend() && (*row)[0] > since; ++row, ++count) {
      sum += (*row)[1];
    }
    return count > 0 ? sum / static_cast<double>(count) : 0.0;
  }

  void validate() {
    ValidationResult result{.step = state_.step, .clips = state_.step * plan_.batch};
    result.error = validation_error();
    result.loss = recent_loss();
    if (state_.best_step < 0) state_.first_error = result.error;
    result.is_best = state_.best_step < 0 || result.error < state_.best_error;
    if (result.is_best) {
      state_.best_error = result.error;
      state_.best_step = state_.step;
      state_.validations_since_best = 0;
    } else {
      ++state_.validations_since_best;
    }
    state_.seconds = seconds_before_ + seconds_since(start_);
    result.seconds = state_.seconds;
    validation_log_.add({static_cast<double>(result.step), static_cast<double>(result.clips),
                         result.seconds, result.loss, result.error});
    save(result.is_best);
    if (options_.on_validation) options_.on_validation(result);
  }

  /// Logs first and the checkpoint last: whatever a kill leaves, the logs reach as far as it does.
  void save(bool is_best) {
    steps_log_.flush();
    validation_log_.flush();
    if (is_best) {
      SafetensorsFile weights = learner_.weight_file();
      weights.metadata[kConfigKey] = options_.config;
      weights.metadata[kStateKey] = text_of(state_);
      write_safetensors(options_.folder / "best.safetensors", weights);
    }
    SafetensorsFile checkpoint = learner_.checkpoint();
    checkpoint.metadata[kConfigKey] = options_.config;
    checkpoint.metadata[kStateKey] = text_of(state_);
    write_safetensors(options_.folder / kCheckpoint, checkpoint);
    draw_curves();
  }

  void draw_curves() const {
    std::vector<CurvePoint> losses;
    for (const auto& row : steps_log_.rows()) losses.push_back({row[0] * plan_.batch, row[1]});
    std::vector<CurvePoint> errors;
    for (const auto& row : validation_log_.rows()) errors.push_back({row[1], row[4]});
    write_image(options_.folder / "curves.png",
                plot_training(losses, errors, std::string(learner_.error_name())));
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
  const ExampleSource& examples_;
  const TrainerOptions& options_;
  const TrainingPlan& plan_;
  ProgressSink& progress_;
  RunState state_;
  bool is_resumed_;
  double seconds_before_;
  Clock::time_point start_ = Clock::now();
  NumberLog steps_log_;
  NumberLog validation_log_;
};

/// A configuration without what may change when a run goes on.
Json without_limits(const std::string& config) {
  Json json = Json::parse(config, nullptr, false);
  if (!json.is_object()) return json;
  for (const char* key : {"steps", "minutes", "patience"}) json["training"].erase(key);
  return json;
}

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

TrainingSummary train(Learner& learner, const ExampleSource& examples,
                      const TrainerOptions& options, const SafetensorsFile* checkpoint,
                      ProgressSink& progress) {
  std::error_code error;
  fs::create_directories(options.folder, error);
  if (error) throw InputError(options.folder.string(), "cannot be made: " + error.message());
  return Run(learner, examples, options, checkpoint, progress).go();
}

std::optional<SafetensorsFile> read_checkpoint(const fs::path& folder, const std::string& config) {
  const fs::path path = folder / kCheckpoint;
  if (!fs::exists(path)) return std::nullopt;
  SafetensorsFile checkpoint = read_safetensors(path);
  const auto found = checkpoint.metadata.find(kConfigKey);
  if (found == checkpoint.metadata.end() ||
      without_limits(found->second) != without_limits(config)) {
    throw InputError(path.string(), "is of a run with another configuration",
                     fmt::format("see {}", (folder / "config.json").string()));
  }
  return checkpoint;
}

void keep_freed_memory() {
  // Without mmap all comes from one heap, whose top is never given back; other threads' arenas are
  // made of maps, so all share this one.
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TOP_PAD, 64 << 20);
}

}  // namespace earpoint

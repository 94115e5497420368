#include "train_command.h"

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/error.h>
#include <earpoint/core/parallel.h>
#include <earpoint/core/progress.h>
#include <earpoint/train/trainer.h>
#include <earpoint/train/training_task.h>

namespace {

namespace fs = std::filesystem;
using earpoint::InputError;

struct Options {
  fs::path config;
  fs::path data;
  fs::path out;
  std::string device = "cpu";
  int jobs = 0;
  int cache_mib = 2048;
  std::optional<double> minutes;
  bool resume = false;
  bool skip_bad = false;
  bool json = false;
  bool quiet = false;
};

/// Says once of every bad example why it is left out.
class BadExamples {
 public:
  void add(const std::string& problem) {
    const std::lock_guard lock(mutex_);
    if (seen_.insert(problem).second) fmt::print(stderr, "earpoint: skipped: {}\n", problem);
  }

 private:
  std::mutex mutex_;
  std::set<std::string> seen_;
};

void report(const earpoint::ValidationResult& result, const std::string& error_name) {
  fmt::print(stderr, "step {}, {} clips, {}: loss {:.5f}, validation {} {:.5f}{}\n", result.step,
             result.clips, earpoint::format_duration(result.seconds), result.loss, error_name,
             result.error, result.is_best ? ", best so far" : "");
}

nlohmann::ordered_json json_of(const earpoint::TrainingSummary& summary) {
  nlohmann::ordered_json json;
  json["steps"] = summary.steps;
  json["clips"] = summary.clips;
  json["seconds"] = summary.seconds;
  json["clips_per_s"] = summary.clips_per_s;
  json["metric"] = summary.error_name;
  json["first"] = summary.first_error;
  json["best"] = summary.best_error;
  json["best_step"] = summary.best_step;
  json["ended_by"] = earpoint::name_of(summary.end);
  return json;
}

earpoint::TrainConfig configuration(const Options& options) {
  earpoint::TrainConfig config = earpoint::read_train_config(options.config);
  if (options.minutes) {
    if (!(*options.minutes > 0.0)) {
      throw InputError("--minutes",
                       fmt::format("expected more than 0, found {:g}", *options.minutes));
    }
    config.training.minutes = options.minutes;
  }
  return config;
}

/// The run to go on with, or nothing to begin one.
std::optional<earpoint::SafetensorsFile> run_so_far(const Options& options,
                                                    const std::string& config) {
  if (!options.resume) {
    if (fs::exists(options.out / "checkpoint.safetensors")) {
      throw InputError(options.out.string(), "holds a run already",
                       "go on with it by --resume, or name another folder");
    }
    return std::nullopt;
  }
  return earpoint::read_checkpoint(options.out, config);
}

void run(const Options& options) {
  earpoint::keep_freed_memory();
  const earpoint::TrainConfig config = configuration(options);
  if (options.jobs < 0) throw InputError("--jobs", "expected 0 or more");
  if (options.cache_mib < 0) throw InputError("--cache", "expected 0 or more");
  earpoint::set_learner_threads(options.jobs > 0 ? options.jobs : earpoint::available_cores());
  const auto checkpoint = run_so_far(options, config.text);

  BadExamples bad;
  earpoint::TaskOptions task_options{.data = options.data,
                                     .device = options.device,
                                     .cache_bytes = static_cast<std::size_t>(options.cache_mib)
                                                    << 20,
                                     .on_bad = {},
                                     .checkpoint = checkpoint ? &*checkpoint : nullptr};
  if (options.skip_bad) {
    task_options.on_bad = [&bad](const std::string& problem) { bad.add(problem); };
  }
  const earpoint::TrainingTask task =
      make_training_task(config, options.config.string(), task_options);

  earpoint::TrainerOptions trainer{
      .folder = options.out, .plan = config.training, .config = config.text, .on_validation = {}};
  if (!options.quiet) {
    trainer.on_validation = [&](const earpoint::ValidationResult& result) {
      report(result, std::string(task.learner->error_name()));
    };
  }
  earpoint::SilentProgress silent;
  earpoint::StreamProgress bar(stderr);
  earpoint::ProgressSink& progress =
      options.quiet ? static_cast<earpoint::ProgressSink&>(silent) : bar;
  const earpoint::TrainingSummary summary =
      train(*task.learner, *task.examples, trainer, task_options.checkpoint, progress);
  if (options.json) {
    fmt::print("{}\n", json_of(summary).dump());
  } else if (!options.quiet) {
    fmt::print("{} {:.5f} at step {} of {} ({} at first); weights in {}\n", summary.error_name,
               summary.best_error, summary.best_step, summary.steps,
               fmt::format("{:.5f}", summary.first_error),
               (options.out / "best.safetensors").string());
  }
}

}  // namespace

void add_train_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "train",
      "Learn a network from a data set. The folder of the run holds best.safetensors, which "
      "`earpoint render --model` takes at once, curves.png, and all that --resume goes on from.");
  command
      ->add_option("config", options->config,
                   "What to learn and how, e.g. configs/vigas-small-single.json")
      ->required();
  command->add_option("--data", options->data, "Folder that `earpoint simulate` wrote")->required();
  command->add_option("--out", options->out, "Folder of the run")->required();
  command->add_flag("--resume", options->resume,
                    "Go on with the run in --out, if there is one: also after a kill");
  command->add_option("--minutes", options->minutes,
                      "End after that time; the learning rate's schedule then follows the clock");
  command->add_option("--device", options->device, "cpu, or cuda where LibTorch has it")
      ->capture_default_str();
  command->add_option("--jobs", options->jobs, "Threads that compute; 0 takes all cores")
      ->capture_default_str();
  command
      ->add_option("--cache", options->cache_mib, "MiB of speech, responses and pictures to keep")
      ->capture_default_str();
  command->add_flag("--skip-bad", options->skip_bad,
                    "Leave out what cannot be read, by name, instead of ending");
  command->add_flag("--json", options->json, "Print how it went as JSON");
  command->add_flag("--quiet", options->quiet, "No progress, no summary");
  command->callback([options] { run(*options); });
}

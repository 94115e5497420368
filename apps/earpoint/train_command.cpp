#include "train_command.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/parallel.h>
#include <earpoint/core/platform/memory.h>
#include <earpoint/core/progress.h>
#include <earpoint/error.h>
#include <earpoint/train/process_group.h>
#include <earpoint/train/trainer.h>
#include <earpoint/train/training_task.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSeveralProcesses = R"(
Several processes can train together on one or several machines; each takes its share of every batch, and
only the first writes into --out. Start them by a launcher,
  torchrun --no-python --nproc-per-node 2 earpoint train CONFIG --data DIR --out RUN
  mpirun -n 4 earpoint train CONFIG --data DIR --out RUN          # on more machines: -x MASTER_ADDR
  srun --ntasks 4 earpoint train CONFIG --data DIR --out RUN      # on more machines: export MASTER_ADDR
or by hand, with RANK (0 to WORLD_SIZE - 1), WORLD_SIZE, MASTER_ADDR and MASTER_PORT in the environment. The
data must be there on every machine. --jobs and --cache count for each process; without --jobs those of one
machine share its cores.
)";

struct Options {
  fs::path config;
  std::vector<std::string> settings;  ///< KEY=VALUE
  std::vector<fs::path> data;
  std::string layout;  ///< empty: whichever there is
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

/// Prints for every bad example, once, why it is left out.
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

void report(const ValidationResult& result, const std::string& error_name) {
  fmt::print(stderr, "step {}, {} clips, {}: loss {:.5f}, validation {} {:.5f}{}\n", result.step,
             result.clips, format_duration(result.seconds), result.loss, error_name, result.error,
             result.is_best ? ", best so far" : "");
}

nlohmann::ordered_json json_of(const TrainingSummary& summary) {
  nlohmann::ordered_json json;
  json["steps"] = summary.steps;
  json["clips"] = summary.clips;
  json["seconds"] = summary.seconds;
  json["clips_per_s"] = summary.clips_per_s;
  json["metric"] = summary.error_name;
  json["first"] = summary.first_error;
  json["best"] = summary.best_error;
  json["best_step"] = summary.best_step;
  json["ended_by"] = name_of(summary.end);
  return json;
}

/// The configuration's file and the settings that override it, for messages.
std::string place_of(const Options& options) {
  std::string place = options.config.string();
  for (const std::string& setting : options.settings) place += " --set " + setting;
  return place;
}

std::vector<ConfigSetting> settings_of(const Options& options) {
  std::vector<ConfigSetting> settings;
  for (const std::string& setting : options.settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw InputError("--set " + setting, "expected KEY=VALUE",
                       "give the path of the key, like training.steps=2000");
    }
    settings.push_back({setting.substr(0, equals), setting.substr(equals + 1)});
  }
  return settings;
}

TrainConfig configuration(const Options& options) {
  TrainConfig config = read_train_config(options.config, settings_of(options), place_of(options));
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
std::optional<SafetensorsFile> run_so_far(const Options& options, const std::string& config) {
  if (!options.resume) {
    if (fs::exists(options.out / "checkpoint.safetensors")) {
      throw InputError(options.out.string(), "holds a run already",
                       "continue it with --resume, or choose another folder");
    }
    return std::nullopt;
  }
  return read_checkpoint(options.out, config);
}

std::vector<std::byte> bytes_of(const std::string& text) {
  std::vector<std::byte> bytes(text.size());
  std::ranges::transform(text, bytes.begin(), [](char c) { return std::byte(c); });
  return bytes;
}

/// All processes must train alike: gradients of another configuration would be averaged unnoticed.
void expect_same_configuration(ProcessGroup& group, const std::string& config) {
  const std::vector<std::byte> own = bytes_of(config);
  double others = group.from_first(own) == own ? 0.0 : 1.0;
  group.sum(std::span(&others, 1));
  if (others > 0.0) {
    throw InputError("training in several processes", "they have different configurations",
                     "start all with the same arguments");
  }
}

struct Start {
  TrainingTask task;
  std::optional<SafetensorsFile> checkpoint;  ///< of a run to go on with
};

/// Makes the task. Of several processes, all start from the weights of the first, bit for bit.
Start started(const Options& options, const TrainConfig& config, TaskOptions task_options,
              ProcessGroup* group) {
  const std::string where = place_of(options);
  Start start;
  if (group == nullptr || group->is_first()) {
    start.checkpoint = run_so_far(options, config.text);
    task_options.checkpoint = start.checkpoint ? &*start.checkpoint : nullptr;
    start.task = make_training_task(config, where, task_options);
  }
  if (group == nullptr) return start;
  const bool goes_on = group->from_first(bytes_of(start.checkpoint ? "on" : "")).size() > 0;
  const char* name = "the first process's checkpoint";
  const std::vector<std::byte> bytes = group->from_first(
      !group->is_first()
          ? std::vector<std::byte>()
          : serialize_safetensors(
                start.checkpoint ? *start.checkpoint : start.task.learner->checkpoint(), name));
  if (group->is_first()) return start;
  start.checkpoint = parse_safetensors(bytes, name);
  task_options.checkpoint = &*start.checkpoint;
  start.task = make_training_task(config, where, task_options);
  if (!goes_on) start.checkpoint.reset();
  return start;
}

/// Threads of this process.
int threads_of(const Options& options, const std::optional<ProcessPlace>& place) {
  if (options.jobs > 0) return options.jobs;
  return std::max(1, available_cores() / (place ? place->local_processes : 1));
}

void run(const Options& options) {
  keep_freed_memory();
  const TrainConfig config = configuration(options);
  if (options.jobs < 0) throw InputError("--jobs", "expected 0 or more");
  if (options.cache_mib < 0) throw InputError("--cache", "expected 0 or more");
  const std::optional<ProcessPlace> place = process_place();
  const int threads = threads_of(options, place);
  set_learner_threads(threads);
  std::optional<ProcessGroup> group;
  if (place) {
    group.emplace(*place);
    expect_same_configuration(*group, config.text);
  }
  ProcessGroup* const processes = group ? &*group : nullptr;

  BadExamples bad;
  TaskOptions task_options{.data = options.data.front(),
                           .more_data = {options.data.begin() + 1, options.data.end()},
                           .layout = std::nullopt,
                           .device = options.device,
                           .cache_bytes = static_cast<std::size_t>(options.cache_mib) << 20,
                           .on_bad = {},
                           .checkpoint = nullptr};
  if (!options.layout.empty()) task_options.layout = layout_named(options.layout);
  if (options.skip_bad) {
    task_options.on_bad = [&bad](const std::string& problem) { bad.add(problem); };
  }
  std::optional<RunLock> lock;  // before the checkpoint is read
  if (!group || group->is_first()) lock.emplace(options.out);
  const Start start = started(options, config, task_options, processes);
  Learner& learner = *start.task.learner;

  const bool tells = !group || group->is_first();
  TrainerOptions trainer{.folder = options.out,
                         .plan = config.training,
                         .config = config.text,
                         .workers = std::max(1, threads / 4),
                         .processes = processes,
                         .on_validation = {}};
  if (tells && !options.quiet) {
    trainer.on_validation = [&](const ValidationResult& result) {
      report(result, std::string(learner.error_name()));
    };
  }
  SilentProgress silent;
  StreamProgress bar(stderr);
  ProgressSink& progress = options.quiet || !tells ? static_cast<ProgressSink&>(silent) : bar;
  const TrainingSummary summary = train(learner, *start.task.examples, trainer,
                                        start.checkpoint ? &*start.checkpoint : nullptr, progress);
  if (!tells) return;
  if (options.json) {
    fmt::print("{}\n", json_of(summary).dump());
  } else if (!options.quiet) {
    const bool is_last = trainer.plan.keep == Keep::last;
    fmt::print("best {} {:.5f} at step {} of {} ({:.5f} at first); {} weights in {}\n",
               summary.error_name, summary.best_error, summary.best_step, summary.steps,
               summary.first_error, is_last ? "the last" : "its",
               (options.out / "best.safetensors").string());
  }
}

}  // namespace

void add_train_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("train", kTrainDescription);
  command
      ->add_option("config", options->config, "Network and training, e.g. configs/vigas-small.json")
      ->required();
  command
      ->add_option("--set", options->settings,
                   "KEY=VALUE: override a value of the configuration, e.g. training.steps=2000 or "
                   "network.box=false; may be repeated")
      ->allow_extra_args(false);
  command
      ->add_option(
          "--data", options->data,
          "Folder of the data set: of earpoint simulate, SoundSpaces-NVAS or Replay-NVAS. "
          "If repeated, training clips of all folders are mixed; validation uses the first "
          "folder")
      ->allow_extra_args(false)  // what comes next may be the configuration
      ->required();
  command
      ->add_option("--layout", options->layout,
                   "Which data set, where a folder holds SoundSpaces-NVAS and Replay-NVAS")
      ->check(CLI::IsMember({"soundspaces", "replay"}));
  command->add_option("--out", options->out, "Folder of the run")->required();
  command->add_flag("--resume", options->resume,
                    "Continue the run in --out, if there is one, also after a kill");
  command->add_option("--minutes", options->minutes,
                      "Stop after that time; the learning rate's schedule then follows the clock");
  command->add_option("--device", options->device, "cpu, or cuda where LibTorch has it")
      ->capture_default_str();
  command->add_option("--jobs", options->jobs, "Threads; 0 takes all cores")->capture_default_str();
  command
      ->add_option("--cache", options->cache_mib, "MiB of speech, responses and pictures to keep")
      ->capture_default_str();
  command->add_flag("--skip-bad", options->skip_bad,
                    "Skip files that cannot be read, naming them, instead of stopping");
  command->add_flag("--json", options->json, "Print the summary as JSON");
  command->add_flag("--quiet", options->quiet, "No progress, no summary");
  command->footer(kSeveralProcesses);
  command->callback([options] { run(*options); });
}

}  // namespace earpoint

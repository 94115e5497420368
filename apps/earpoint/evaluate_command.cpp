#include "evaluate_command.h"

#include "arguments.h"
#include "evaluate_methods.h"
#include "rt60_model.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/core/error.h>
#include <earpoint/core/parallel.h>
#include <earpoint/core/progress.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/evaluate/evaluation.h>
#include <earpoint/evaluate/evaluation_table.h>
#include <earpoint/evaluate/report.h>
#include <earpoint/infer/rt60_estimator.h>
#include <earpoint/model/weights.h>

namespace {

namespace fs = std::filesystem;
using earpoint::InputError;

constexpr std::size_t kCacheBytes = std::size_t{512} << 20U;

// White noise at full scale against silence has a Mag of about 25.
constexpr double kAbsurdMag = 100.0;

// As loud as in the configurations that learn enhancement.
constexpr double kEnhancedAmbientDb = -40.0;
constexpr std::array<earpoint::Metric, 3> kEnhancementMetrics{
    earpoint::Metric::mag, earpoint::Metric::rte, earpoint::Metric::level};

constexpr const char* kExamples = R"(
Examples:
  earpoint evaluate --data data/homes --methods input,dsp
  earpoint evaluate --data data/homes --methods input,dsp,mine=runs/mine/best.safetensors --json
  earpoint evaluate --data data/homes --methods input,tf,dsp,vigas --oracles --report out
  earpoint evaluate --data data/homes --enhance --methods input,mine=runs/enhance/best.safetensors
  earpoint evaluate --data data/homes --ablations --runs runs/ablations

Methods:
  input    the source's sound as it is
  dsp      inverse and forward head filters, told where the speaker truly is
  tf       Wiener filters of the nearest pair of the training split, by true positions
  NAME     a model that comes with Earpoint, e.g. vigas
  NAME=FILE  a weight file, in a row of that name
Oracles, which are shown part of the answer (--oracles: all), from the lowest rung up:
  oracle-gain        true level of each ear
  oracle-bands       true level of each frequency and ear
  oracle-dry-direct  true dry speech and direct path, tail of noise with the true decay
  oracle-expected    the same, but the magnitudes to be expected over many such tails: best by Mag
  oracle-all         everything known: 0
Data sets (docs/datasets.md): one of `earpoint simulate` or `earpoint record prepare`, or a download of SoundSpaces-NVAS or Replay-NVAS,
named by the folder that holds data/synthetic_dataset/v16 or data/appen_dataset/v3, or by one of these.
Pairs come from pairs-<split>.json. Where there is none, as in the downloads, they are drawn: every viewpoint
of SoundSpaces-NVAS the target once, in random seconds; of Replay-NVAS as the released test draws them. The
paper's numbers on SoundSpaces-NVAS are of first seconds: --draw released draws those. Absolute values of
different seconds do not compare; ratios to input do better.
Room noise (--ambient -40) falls by 6 dB an octave from 20 Hz on and is independent at each ear. It is
separated as the paper separates ambient sound, by a high-pass at 80 Hz: methods hear what is above, and
answer what the clean target is compared with. A network that was trained without separation hears all of
the noise, and what it answers goes through the same high-pass.
Enhancement (--enhance) asks for the dry speech as a microphone close before the mouth records it, as loud as
it is 1 m away in free field, in room noise of -40 dB unless --ambient says otherwise. Methods are not told
where that microphone is; tf and dsp, which answer for a place, have no row.
Every number is an error: 0 is best. Intervals hold the mean at 95 % confidence, drawn by home where there
are several, else by conversation.
)";

struct Options {
  fs::path data;
  std::string split = "test";
  std::string layout;  ///< empty: whichever there is
  std::optional<fs::path> pairs;
  std::string draw;  ///< empty: the list
  MethodRequest methods;
  std::optional<std::size_t> limit;
  int jobs = 0;
  fs::path rt60_model;
  std::optional<fs::path> report;
  std::optional<double> ambient_db;
  bool enhance = false;
  bool skip_bad = false;
  bool json = false;
  bool quiet = false;
};

/// Makes the estimator behind RTE, or nothing where there is none.
std::function<earpoint::ReverberationEstimator()> estimator_maker(const fs::path& given) {
  const std::optional<fs::path> model = rt60_model(given);
  if (!model) {
    fmt::print(stderr, "earpoint: {}\n", kNoRt60Model);
    return {};
  }
  auto weights = std::make_shared<earpoint::Rt60EstimatorWeights>(
      earpoint::read_rt60_estimator_weights(*model));
  return [weights]() -> earpoint::ReverberationEstimator {
    auto estimator = std::make_shared<earpoint::Rt60Estimator>(*weights);
    return [estimator](const earpoint::Waveform& sound) { return estimator->estimate_s(sound); };
  };
}

earpoint::PairTarget target_of(const Options& options) {
  return options.enhance ? earpoint::PairTarget::near_microphone : earpoint::PairTarget::viewpoint;
}

/// Level of room noise in dB re full scale, or none.
std::optional<double> ambient_db(const Options& options) {
  if (options.ambient_db || !options.enhance) return options.ambient_db;
  return kEnhancedAmbientDb;
}

std::unique_ptr<earpoint::EvaluationSet> recorded_set(const Options& options) {
  if (options.enhance) {
    throw InputError("--enhance", "wants simulated data, whose dry speech is known",
                     "make some with `earpoint simulate`");
  }
  if (options.ambient_db) {
    throw InputError("--ambient", "recordings have ambient sound of their own",
                     "leave it out, or take simulated data");
  }
  if (options.pairs) {
    throw InputError("--pairs",
                     "Replay-NVAS has no pair lists; its pairs are drawn as the released "
                     "test draws them",
                     "leave it out");
  }
  if (options.draw == "every-target") {
    throw InputError("--draw every-target", "Replay-NVAS is drawn as the released test draws it",
                     "leave it out");
  }
  return earpoint::replay_evaluation_set(options.data, options.split, options.limit);
}

earpoint::DatasetLayout layout_of(const Options& options) {
  std::optional<earpoint::DatasetLayout> asked;
  if (!options.layout.empty()) asked = earpoint::layout_named(options.layout);
  return dataset_layout(options.data, asked);
}

std::unique_ptr<earpoint::EvaluationSet> evaluation_set(const Options& options) {
  if (layout_of(options) == earpoint::DatasetLayout::replay) {
    return recorded_set(options);
  }
  earpoint::PairChoice pairs{.list = options.pairs, .draw = std::nullopt};
  if (!options.draw.empty()) pairs.draw = earpoint::draw_named(options.draw);
  auto set = earpoint::soundspaces_evaluation_set(options.data, options.split, pairs, options.limit,
                                                  kCacheBytes, target_of(options));
  const std::optional<double> level_db = ambient_db(options);
  return level_db ? with_ambient(std::move(set), *level_db) : std::move(set);
}

/// The released loader takes the samples of 16-bit speech as integers, 32768 times too loud.
void warn_of_levels(const earpoint::EvaluationTable& table) {
  for (const earpoint::TableRow& row : table.rows) {
    const auto& mag = row[earpoint::Metric::mag].mean;
    if (!mag || mag->value < kAbsurdMag) continue;
    fmt::print(
        stderr,
        "earpoint: a Mag of {:.0f} is of sounds far above full scale: 16-bit speech files are "
        "taken as whole numbers, as the released loader takes them; convert "
        "data/LibriSpeech-wav to 32-bit float (docs/datasets.md)\n",
        mag->value);
    return;
  }
}

void run(const Options& options) {
  if (options.jobs < 0) {
    throw InputError("--jobs", fmt::format("expected 0 or more, found {}", options.jobs));
  }
  const std::unique_ptr<earpoint::EvaluationSet> set = evaluation_set(options);
  std::set<std::string> scenes;
  for (std::size_t pair = 0; pair < set->size(); ++pair) scenes.insert(set->scene(pair));
  MethodRequest request = options.methods;
  request.data = options.data;
  request.enhance = options.enhance;
  request.layout = layout_of(options);
  request.recorded = request.layout == earpoint::DatasetLayout::replay;
  request.knows_speaker = set->knows_speaker();
  if (request.words.empty()) {
    request.words = {"input"};
    if (!options.enhance && set->knows_speaker()) request.words.emplace_back("dsp");
  }
  const std::vector<earpoint::MethodEntry> methods = methods_of(request, scenes);

  earpoint::EvaluationOptions how;
  how.jobs = options.jobs > 0 ? options.jobs : earpoint::available_cores();
  how.skip_bad = options.skip_bad;
  how.make_estimator = estimator_maker(options.rt60_model);

  earpoint::SilentProgress silent;
  earpoint::StreamProgress bar(stderr);
  earpoint::ProgressSink& progress =
      options.quiet ? static_cast<earpoint::ProgressSink&>(silent) : bar;
  const earpoint::EvaluationResult result = evaluate(*set, methods, how, progress);
  for (const earpoint::BadPair& pair : result.skipped) {
    fmt::print(stderr, "earpoint: left out {}: {}\n", pair.name, pair.problem);
  }
  if (options.report) {
    earpoint::ReportOptions report;
    report.data = options.data.string();
    if (options.enhance) report.data += ", speech to be enhanced";
    if (const auto level_db = ambient_db(options)) {
      report.data += fmt::format(", room noise {:g} dB", *level_db);
    }
    report.split = options.split;
    report.pairs = set->pairs();
    write_report(*options.report, *set, methods, result, report, progress);
  }
  const earpoint::EvaluationTable table = make_table(result);
  const earpoint::EvaluationSubject subject{options.data.string(), options.split, set->pairs(),
                                            target_of(options), ambient_db(options)};
  const std::span<const earpoint::Metric> told =
      options.enhance ? kEnhancementMetrics : earpoint::told_metrics();
  if (options.json) {
    fmt::print("{}", json_of(table, subject));
  } else {
    fmt::print("{}Pairs: {}.\n", text_of(table, told), set->pairs());
  }
  warn_of_levels(table);
}

}  // namespace

void add_evaluate_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "evaluate", "Measure methods side by side on the frozen pairs of a data set.");
  command
      ->add_option("--data", options->data,
                   "Folder of the data set: of earpoint simulate, SoundSpaces-NVAS or Replay-NVAS")
      ->required();
  command->add_option("--split", options->split, "Whose pairs")->capture_default_str();
  command
      ->add_option("--layout", options->layout,
                   "Which data set, where a folder holds SoundSpaces-NVAS and Replay-NVAS")
      ->check(CLI::IsMember({"soundspaces", "replay"}));
  auto* pairs = command->add_option("--pairs", options->pairs,
                                    "Another pair list than pairs-<split>.json of the data set");
  command
      ->add_option("--draw", options->draw,
                   "Draw pairs instead, as `earpoint pairs` does; see below")
      ->check(CLI::IsMember({"every-target", "released"}))
      ->excludes(pairs);
  auto* methods = command
                      ->add_option("--methods", options->methods.words,
                                   "What to compare, separated by commas; default: input,dsp; "
                                   "input alone with --enhance "
                                   "and on recordings")
                      ->delimiter(',');
  command
      ->add_flag(
          "--ablations", options->methods.ablations,
          "Compare input with every shipped model of the families gtf and vigas, or every run "
          "of --runs")
      ->excludes(methods);
  command->add_option("--runs", options->methods.runs,
                      "Folder of training runs: a row for the best weights of each");
  command->add_flag("--oracles", options->methods.oracles, "The ladder of oracles as well");
  command
      ->add_option("--tf-index", options->methods.tf_index,
                   "How tf looks up: by locations in the scene or by relative pose; default: "
                   "locations if the scenes are among those of the training split")
      ->check(CLI::IsMember({"locations", "relative"}));
  command->add_option("--limit", options->limit, "Take that many pairs, spread over the list")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--ambient", options->ambient_db,
                   "Level in dB re full scale of room noise in what the source hears, the same for "
                   "every method; see below")
      ->check(earpoint::within(-120.0, 0.0));
  command->add_flag(
      "--enhance", options->enhance,
      "Enhancement of speech instead: the target is the speaker's near microphone; see "
      "below");
  command->add_option("--jobs", options->jobs, "Threads; 0 takes all cores")->capture_default_str();
  command->add_option("--rt60-model", options->rt60_model,
                      "Weight file of the estimator behind rte_s (default: the shipped one)");
  command->add_option("--report", options->report,
                      "Folder for a page with tables, curves, and clips to look at and listen to");
  command->add_flag("--skip-bad", options->skip_bad,
                    "Leave out pairs whose files are missing or broken, naming them");
  command->add_flag("--json", options->json, "Print the tables as JSON");
  command->add_flag("--quiet", options->quiet, "No progress");
  command->footer(kExamples);
  command->callback([options] { run(*options); });
}

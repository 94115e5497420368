#include "evaluate_command.h"

#include "arguments.h"
#include "evaluate_earpoints.h"
#include "evaluate_figure.h"
#include "evaluate_methods.h"
#include "evaluate_set.h"
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

#include <earpoint/core/parallel.h>
#include <earpoint/core/progress.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/speaker_boxes.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/evaluation.h>
#include <earpoint/evaluate/evaluation_table.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/evaluate/report.h>
#include <earpoint/rt60/engine.h>
#include <earpoint/rt60/weights.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

// White noise at full scale against silence has a Mag of about 25.
constexpr double kAbsurdMag = 100.0;

constexpr std::array<Metric, 5> kEnhancementMetrics{Metric::mag, Metric::rte, Metric::level,
                                                    Metric::si_sdr, Metric::estoi};

constexpr const char* kExamples = R"(
Examples:
  earpoint evaluate --data data/homes --methods input,dsp
  earpoint evaluate --data data/homes --methods input,dsp,mine=runs/mine/best.safetensors --json
  earpoint evaluate --data data/homes --methods input,tf,dsp,vigas --oracles --report out
  earpoint evaluate --data data/homes --enhance --methods input,mine=runs/enhance/best.safetensors
  earpoint evaluate --data data/homes --ablations --runs runs/ablations
  earpoint evaluate --data data/homes --boxes detected --methods input,dsp,gtf
  earpoint evaluate --earpoints examples/earpoints.json --report out
  earpoint evaluate --earpoints examples/earpoints.json --figure clip.svg
  earpoint evaluate --data data/homes --figure clips.svg --clips home-0/3,home-2/1:2 --methods dsp,gtf

Methods:
  input    the unchanged sound of the source
  dsp      inverse and forward head filters, given the speaker's true position
  tf       Wiener filters of the nearest pair of the training split, by true positions
  NAME     a shipped model, e.g. vigas
  NAME=FILE  a weight file, in a row of that name
  ...:mean   the mean texture of a network that was trained for two (render --texture); a number from
             0, the mean, to 1, the natural one, for what lies between
Oracles, which are given part of the answer (--oracles: all), from the least to the most:
  oracle-gain        true level of each ear
  oracle-bands       true level of each frequency and ear
  oracle-dry-direct  true dry speech and direct path, tail of noise with the true decay
  oracle-expected    the same, with median magnitudes over many such tails: best by Mag
  oracle-all         the complete answer: 0
Data sets (docs/datasets.md): one of `earpoint simulate` or `earpoint record prepare`, or a download of
SoundSpaces-NVAS or Replay-NVAS, named by the folder that holds data/synthetic_dataset/v16 or
data/appen_dataset/v3, or by one of these.
Of RWAVS (the folder with position.json, or one scene) --split val or train is measured at every pose, by input
and dsp: methods get the dry sound, scaled to the level of the training split, and the positions; distances are
relative to a mean of 2 m, for the published coordinates have no unit.
Pairs come from pairs-<split>.json. Where there is none, as in the downloads, they are drawn: every viewpoint
of SoundSpaces-NVAS the target once, in random seconds; of Replay-NVAS as the released test draws them. The
paper's numbers on SoundSpaces-NVAS are for first seconds: --draw released draws those. Absolute values of
different seconds cannot be compared; ratios to input compare better.
Room noise (--ambient -40) falls by 6 dB an octave from 20 Hz on and is independent at each ear. It is
separated as in the paper, by a high-pass at 80 Hz (--ambient -40,bandpass), or also by spectral subtraction
or log-MMSE of tracked noise: methods get the primary sound, and their output is compared with the clean
target. The SI-SDR of the primary sound is printed. A network that was trained without separation gets all of
the noise, and its output goes through the high-pass.
dsp and networks are run as `earpoint render` runs them, on the window of one second alone, as in the paper,
or with --context 4 on the four seconds before it too (silence before the speech): windows overlap and are
cross-faded, and the last second is compared. The target and the input of other methods are the same.
Enhancement (--enhance): the target is the dry speech of a microphone close to the mouth, at its level 1 m
away in free field; the source has room noise of -40 dB unless --ambient is given. Of recorded clips it is
near.wav, whose gain is not known: it is made as loud as the source and moved to it by GCC-PHAT. Methods do
not get the position of that microphone; tf and dsp, which render for a position, have no row.
A clip of your own (--earpoints) needs no data set: a JSON file names the clip, and earpoints with the true
sound there (docs/formats.md). It is rendered as `earpoint render` does, by input, dsp, shipped models and
weight files; for gtf the speaker is found in the picture. Without --json one table is printed.
A figure (--figure) shows clips as in the paper: the source's picture with the speaker's box, targets, the
left and right ear of every sound side by side, and the enhanced speech on the right. --clips names clips of
the data set as SCENE/CLIP or SCENE/CLIP:SOURCE, e.g. SC-1027/3:5; the default is the first clip whose source
sees the speaker, or --limit of them. The default method is gtf. Of a data set nothing is measured then.
Every number is an error, and 0 is best; of SI-SDR and ESTOI (--enhance) more is better. Intervals have 95 %
confidence, bootstrapped by home where there are several, else by conversation.
)";

/// Makes the estimator behind RTE, or nothing where there is none.
std::function<ReverberationEstimator()> estimator_maker(const fs::path& given) {
  const std::optional<fs::path> model = rt60_model(given);
  if (!model) {
    fmt::print(stderr, "earpoint: {}\n", kNoRt60Model);
    return {};
  }
  auto weights = std::make_shared<Rt60EstimatorWeights>(read_rt60_estimator_weights(*model));
  return [weights]() -> ReverberationEstimator {
    auto estimator = std::make_shared<Rt60Estimator>(*weights);
    return [estimator](const Waveform& sound) { return estimator->estimate_s(sound); };
  };
}

/// The released loader takes the samples of 16-bit speech as integers, 32768 times too loud.
void warn_of_levels(const EvaluationTable& table) {
  for (const TableRow& row : table.rows) {
    const auto& mag = row[Metric::mag].mean;
    if (!mag || mag->value < kAbsurdMag) continue;
    fmt::print(stderr,
               "earpoint: warning: a Mag of {:.0f} means sounds far above full scale: 16-bit "
               "speech files are "
               "read as integers, as the released loader does; convert "
               "data/LibriSpeech-wav to 32-bit float (docs/datasets.md)\n",
               mag->value);
    return;
  }
}

void check_boxes(SpeakerBoxes boxes, std::span<const MethodEntry> methods) {
  if (boxes != SpeakerBoxes::none) return;
  for (const MethodEntry& method : methods) {
    if (!method.needs_speaker) continue;
    throw InputError("--methods " + method.name, "needs the speaker's position",
                     "leave it out with --boxes none, or use --boxes detected");
  }
}

void run_on_clip(const EvaluateOptions& options) {
  const auto make_estimator = estimator_maker(options.rt60_model);
  const EarpointsRequest request{
      .description = options.earpoints,
      .methods = options.methods.words,
      .report = options.report,
      .figure = options.figure,
      .estimator = make_estimator ? make_estimator() : ReverberationEstimator{},
      .detector = options.detector.value_or("").string(),
      .threads = options.jobs > 0 ? options.jobs : available_cores(),
      .json = options.json,
      .quiet = options.quiet};
  SilentProgress silent;
  StreamProgress bar(stderr);
  evaluate_earpoints(request, options.quiet ? static_cast<ProgressSink&>(silent) : bar);
}

/// Clips instead of numbers.
void run_figure(const EvaluateOptions& options) {
  FigureRequest request{.output = *options.figure,
                        .methods = options.methods,
                        .split = options.split,
                        .clips = options.clips,
                        .count = options.limit.value_or(1)};
  request.methods.data = options.data;
  request.methods.layout = layout_of(options);
  if (request.methods.layout == DatasetLayout::rwavs) {
    throw InputError("--figure", "RWAVS has no source view to draw", "leave it out");
  }
  request.methods.recorded = request.methods.layout == DatasetLayout::replay;
  if (request.methods.words.empty()) request.methods.words = {"gtf"};
  SilentProgress silent;
  StreamProgress bar(stderr);
  draw_figure(request, options.quiet ? static_cast<ProgressSink&>(silent) : bar);
}

/// The request for methods_of(): the options, and what the data set holds.
MethodRequest method_request(const EvaluateOptions& options, const EvaluationSet& set) {
  MethodRequest request = options.methods;
  request.data = options.data;
  request.enhance = options.enhance;
  request.layout = layout_of(options);
  request.recorded = request.layout != DatasetLayout::soundspaces;
  request.knows_speaker = set.knows_speaker();
  if (request.words.empty()) {
    request.words = {"input"};
    const bool is_told = boxes_named(options.boxes) != SpeakerBoxes::none;
    if (!options.enhance && set.knows_speaker() && is_told) request.words.emplace_back("dsp");
  }
  return request;
}

EvaluationOptions evaluation_options(const EvaluateOptions& options) {
  EvaluationOptions how;
  how.jobs = options.jobs > 0 ? options.jobs : available_cores();
  how.skip_bad = options.skip_bad;
  how.judges_speech = options.enhance;
  how.make_estimator = estimator_maker(options.rt60_model);
  how.make_telling = telling_maker(boxes_named(options.boxes), options.detector);
  return how;
}

/// Describes the data for the report.
ReportOptions report_options(const EvaluateOptions& options, const EvaluationSet& set) {
  ReportOptions report;
  report.data = options.data.string();
  if (options.enhance) report.data += ", speech to be enhanced";
  const EvaluateAmbient ambient = ambient_of(options);
  if (ambient.level_db) {
    report.data += fmt::format(", room noise {:g} dB, separated by {}", *ambient.level_db,
                               name_of(ambient.separation));
  }
  if (options.context_s > 0.0) {
    report.data += fmt::format(", {:g} s of sound before", options.context_s);
  }
  if (options.boxes != "true") report.data += ", boxes: " + options.boxes;
  report.split = options.split;
  report.pairs = set.pairs();
  return report;
}

void print_result(const EvaluateOptions& options, const EvaluationSet& set,
                  const EvaluationTable& table) {
  if (options.json) {
    const EvaluateAmbient ambient = ambient_of(options);
    fmt::print("{}", json_of(table, {options.data.string(), options.split, set.pairs(),
                                     target_of(options), ambient.level_db, ambient.separation,
                                     options.context_s, options.boxes}));
    return;
  }
  const std::span<const Metric> told = options.enhance ? kEnhancementMetrics : told_metrics();
  fmt::print("{}Pairs: {}.\n", text_of(table, told), set.pairs());
}

void run_on_data(const EvaluateOptions& options) {
  const std::unique_ptr<EvaluationSet> set = evaluation_set(options);
  std::set<std::string> scenes;
  for (std::size_t pair = 0; pair < set->size(); ++pair) scenes.insert(set->scene(pair));
  const std::vector<MethodEntry> methods = methods_of(method_request(options, *set), scenes);
  check_boxes(boxes_named(options.boxes), methods);
  SilentProgress silent;
  StreamProgress bar(stderr);
  ProgressSink& progress = options.quiet ? static_cast<ProgressSink&>(silent) : bar;
  const EvaluationResult result = evaluate(*set, methods, evaluation_options(options), progress);
  for (const BadPair& pair : result.skipped) {
    fmt::print(stderr, "earpoint: left out {}: {}\n", pair.name, pair.problem);
  }
  if (options.report) {
    write_report(*options.report, *set, methods, result, report_options(options, *set), progress);
  }
  const EvaluationTable table = make_table(result);
  print_result(options, *set, table);
  warn_of_levels(table);
}

void run(const EvaluateOptions& options) {
  if (options.jobs < 0) {
    throw InputError("--jobs", fmt::format("expected 0 or more, found {}", options.jobs));
  }
  if (!options.earpoints.empty()) return run_on_clip(options);
  if (options.data.empty()) {
    throw InputError("--data", "missing", "give a data set, or a clip with --earpoints");
  }
  if (options.figure) return run_figure(options);
  run_on_data(options);
}

}  // namespace

void add_evaluate_command(CLI::App& app) {
  auto options = std::make_shared<EvaluateOptions>();
  CLI::App* command = app.add_subcommand(
      "evaluate", "Compare methods on the frozen pairs of a data set, or on a clip of your own.");
  command->add_option(
      "--data", options->data,
      "Folder of the data set: of earpoint simulate, SoundSpaces-NVAS, Replay-NVAS or "
      "RWAVS");
  auto* earpoints = command->add_option(
      "--earpoints", options->earpoints,
      "Instead of a data set: a JSON file with a clip and its true sound at other positions");
  command->add_option("--split", options->split, "Split of the pairs")->capture_default_str();
  command
      ->add_option(
          "--layout", options->layout,
          "Which data set, where a folder holds SoundSpaces-NVAS and Replay-NVAS; or rwavs")
      ->check(CLI::IsMember({"soundspaces", "replay", "rwavs"}));
  auto* pairs = command->add_option("--pairs", options->pairs,
                                    "Another pair list than pairs-<split>.json of the data set");
  command
      ->add_option("--draw", options->draw,
                   "Draw pairs instead, as `earpoint pairs` does; see below")
      ->check(CLI::IsMember({"every-target", "released"}))
      ->excludes(pairs);
  auto* methods = command
                      ->add_option("--methods", options->methods.words,
                                   "Methods to compare, separated by commas; default: input,dsp; "
                                   "input alone with --enhance "
                                   "and on recordings; input,dsp,gtf with --earpoints")
                      ->delimiter(',');
  command
      ->add_flag(
          "--ablations", options->methods.ablations,
          "Compare input with every shipped model of the families gtf and vigas, or every run "
          "of --runs")
      ->excludes(methods);
  command->add_option("--runs", options->methods.runs,
                      "Folder of training runs: a row for the best weights of each");
  command->add_flag("--oracles", options->methods.oracles, "Add the oracles");
  command
      ->add_option(
          "--tf-index", options->methods.tf_index,
          "How tf finds the nearest pair: by locations in the scene or by relative pose; default: "
          "locations if the scenes are among those of the training split")
      ->check(CLI::IsMember({"locations", "relative"}));
  command->add_option("--limit", options->limit, "Use that many pairs, spread over the list")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--ambient", options->ambient,
                   "Room noise in the source's sound, the same for every method: its level in dB "
                   "re full scale, how it is separated (bandpass, subtract, mmse), or both: "
                   "-40,mmse; see below")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option("--context", options->context_s,
                   "Seconds of preceding sound for dsp and networks; see below")
      ->check(within(0.0, 60.0))
      ->capture_default_str();
  command->add_flag(
      "--enhance", options->enhance,
      "Enhancement of speech instead: the target is the speaker's near microphone; see "
      "below");
  command
      ->add_option(
          "--boxes", options->boxes,
          "What methods get of the speaker: the true box and position, those of the person "
          "detected as the speaker, or nothing")
      ->check(CLI::IsMember({"true", "detected", "none"}))
      ->capture_default_str();
  command->add_option("--detector", options->detector,
                      "People detector for --boxes detected and --earpoints: a weight file or an "
                      ".onnx network, or none with --earpoints; default: the shipped network");
  command->add_option("--jobs", options->jobs, "Threads; 0 takes all cores")->capture_default_str();
  command->add_option("--rt60-model", options->rt60_model,
                      "Weight file of the estimator behind rte_s (default: the shipped one)");
  command->add_option("--report", options->report,
                      "Folder for a page with tables, curves, pictures and players");
  auto* figure = command->add_option(
      "--figure", options->figure,
      "An .svg file: pictures and waveforms of clips at the source and at targets; see below");
  command->add_option("--clips", options->clips, "Clips of the figure, separated by commas")
      ->delimiter(',')
      ->needs(figure);
  command->add_flag("--skip-bad", options->skip_bad,
                    "Skip pairs whose files are missing or broken, naming them");
  command->add_flag("--json", options->json, "Print the tables as JSON");
  command->add_flag("--quiet", options->quiet, "No progress");
  for (const char* name :
       {"--data", "--split", "--layout", "--pairs", "--draw", "--ablations", "--runs", "--oracles",
        "--tf-index", "--limit", "--ambient", "--enhance", "--boxes", "--clips", "--skip-bad"}) {
    command->get_option(name)->excludes(earpoints);
  }
  for (const char* name : {"--pairs", "--draw", "--ablations", "--runs", "--oracles", "--ambient",
                           "--context", "--enhance", "--boxes"}) {
    command->get_option(name)->excludes(figure);
  }
  command->footer(kExamples);
  command->callback([options] { run(*options); });
}

}  // namespace earpoint

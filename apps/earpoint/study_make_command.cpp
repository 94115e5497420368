#include "arguments.h"
#include "evaluate_methods.h"
#include "study_command.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/core/parallel.h>
#include <earpoint/core/progress.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/error.h>
#include <earpoint/study/make_study.h>
#include <earpoint/study/webmushra.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFooter = R"(
Designs:
  choice   as in the paper: picture and sound of the target as reference, and a sound of every method, unnamed
           and in random order; which is closest? With --controls, clips are mixed in where one of the sounds is
           the reference, to screen inattentive participants.
  mushra   after ITU-R BS.1534: every method, the hidden reference, and as anchors the reference in mono and
           with its ears exchanged are rated from 0 to 100, in one part by position and in one by timbre.
Clips are drawn by the seed from the frozen pairs of the data set, each from another conversation and from as
many homes as possible. Methods are those of `earpoint evaluate --methods`, rendered by the code of
`earpoint render`. Sounds of a clip are matched to the loudness of its reference (BS.1770); --loudness kept
keeps the methods' own levels.

Examples:
  earpoint study make --data data/homes --methods input,dsp,vigas,gtf --count 20 --seed 1 -o study
  earpoint study make --data data/homes --methods input,dsp,mine=runs/mine/best.safetensors -o study
  earpoint study make --data data/homes --design mushra --methods input,dsp,gtf --count 8 -o ratings
  earpoint study make --data data/recorded --methods input,dsp,gtf --seconds 1 -o recorded)";

struct Arguments {
  fs::path data;
  std::optional<fs::path> pairs;
  std::vector<std::string> methods{"input", "dsp", "gtf"};
  std::vector<std::string> baselines{"input", "dsp", "tf"};
  std::string design = "choice";
  std::string loudness = "matched";
  StudyRequest request;
  fs::path output;
  int jobs = 0;
  bool webmushra = false;
  bool quiet = false;
};

std::string name_of_folder(const fs::path& folder) {
  return fs::absolute(folder / ".").lexically_normal().parent_path().filename().string();
}

void run(const Arguments& arguments) {
  StudyRequest request = arguments.request;
  request.design = study_design_named(arguments.design);
  request.data = name_of_folder(arguments.data);
  request.match_loudness = arguments.loudness == "matched";
  request.baselines = {arguments.baselines.begin(), arguments.baselines.end()};
  request.jobs = arguments.jobs > 0 ? arguments.jobs : available_cores();
  const DatasetLayout layout = dataset_layout(arguments.data, std::nullopt);
  const auto material =
      study_material(arguments.data, layout, request.split, arguments.pairs, request.duration_s);
  std::set<std::string> scenes;
  for (std::size_t pair = 0; pair < material->size(); ++pair) scenes.insert(material->scene(pair));
  MethodRequest methods;
  methods.words = arguments.methods;
  methods.data = arguments.data;
  methods.layout = layout;
  methods.recorded = layout == DatasetLayout::replay;
  methods.knows_speaker = material->knows_speaker();
  SilentProgress silent;
  StreamProgress bar(stderr);
  ProgressSink& progress = arguments.quiet ? static_cast<ProgressSink&>(silent) : bar;
  const Study study =
      make_study(*material, methods_of(methods, scenes), request, arguments.output, progress);
  if (arguments.webmushra) {
    const std::string place = "configs/" + name_of_folder(arguments.output);
    write_file(arguments.output / "webmushra.yaml", webmushra_yaml(study, place));
  }
  fmt::print("{}: {} clips, {} methods, design {}\n", arguments.output.string(), study.clips.size(),
             study.methods.size(), name_of(study.design));
}

}  // namespace

void add_study_make_command(CLI::App& study) {
  auto arguments = std::make_shared<Arguments>();
  StudyRequest& request = arguments->request;
  request.title = "Listening study";
  request.split = "test";
  CLI::App* command =
      study.add_subcommand("make", "Draw clips, render every method, and write a study's folder.");
  command
      ->add_option("--data", arguments->data,
                   "Folder of the data set: of earpoint simulate or record prepare, or published")
      ->required();
  command->add_option("--split", request.split, "Split of the pairs")->capture_default_str();
  command->add_option("--pairs", arguments->pairs,
                      "Another pair list than pairs-<split>.json of the data set");
  command->add_option("--methods", arguments->methods, "Methods to compare, separated by commas")
      ->delimiter(',')
      ->capture_default_str();
  command
      ->add_option("--baselines", arguments->baselines,
                   "Methods that the others are tested against")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--design", arguments->design, "choice or mushra; see below")
      ->check(CLI::IsMember({"choice", "mushra"}))
      ->capture_default_str();
  command->add_option("--count", request.count, "Number of clips")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--controls", request.controls,
                   "Further clips of the design choice that "
                   "have the reference among the sounds")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  command->add_option("--seconds", request.duration_s, "Length of every sound")
      ->check(within(0.5, 20.0))
      ->capture_default_str();
  command->add_option("--seed", request.seed, "Seed of the draws and of participants' orders")
      ->capture_default_str();
  command->add_option("--loudness", arguments->loudness, "matched or kept; see below")
      ->check(CLI::IsMember({"matched", "kept"}))
      ->capture_default_str();
  command->add_option("--title", request.title, "What participants see above the page")
      ->capture_default_str();
  command->add_flag("--webmushra", arguments->webmushra,
                    "Write webmushra.yaml for webMUSHRA, which expects the folder in its configs/");
  command->add_option("--jobs", arguments->jobs, "Threads; 0 takes all cores")
      ->capture_default_str();
  command->add_option("-o,--output", arguments->output, "Folder of the study; must not exist")
      ->required();
  command->add_flag("--quiet", arguments->quiet, "No progress");
  command->footer(kFooter);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace earpoint

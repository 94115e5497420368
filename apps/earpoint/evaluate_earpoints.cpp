#include "evaluate_earpoints.h"

#include "evaluate_figure.h"
#include "speaker_search.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/core/temporary_folder.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/earpoint_comparison.h>
#include <earpoint/network/model_names.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

ClipMethod method_of(const std::string& word) {
  if (word == "input" || word == "dsp") return {word, word};
  if (const auto equals = word.find('='); equals != std::string::npos) {
    if (equals == 0 || equals + 1 == word.size()) {
      throw InputError("--methods " + word, "expected NAME=FILE");
    }
    return {word.substr(0, equals), word.substr(equals + 1)};
  }
  if (const auto path = shipped_model(word)) {
    return {word, path->string()};
  }
  throw InputError("--methods " + word,
                   "is neither input, dsp nor a shipped model; a clip has no other methods",
                   "name a weight file: " + word + "=FILE.safetensors");
}

std::vector<ClipMethod> methods_of(const EarpointsRequest& request, const EarpointClip& clip) {
  std::vector<std::string> words = request.methods;
  if (words.empty()) {
    words.emplace_back("input");
    if (clip.speaker_m || clip.speaker_box) words.emplace_back("dsp");
    words.emplace_back("gtf");
  }
  std::vector<ClipMethod> methods;
  for (const std::string& word : words) {
    ClipMethod method = method_of(word);
    // It is part of a file's name.
    if (method.name.find('/') != std::string::npos) {
      throw InputError("--methods " + word, "has a name with a slash");
    }
    if (std::ranges::find(methods, method.name, &ClipMethod::name) != methods.end()) {
      throw InputError("--methods", "names " + method.name + " twice", "give one NAME=FILE");
    }
    methods.push_back(std::move(method));
  }
  return methods;
}

}  // namespace

void evaluate_earpoints(const EarpointsRequest& request, ProgressSink& progress) {
  if (request.figure) check_figure_path(*request.figure);
  const EarpointClip clip = read_earpoint_clip(request.description);
  const std::vector<ClipMethod> methods = methods_of(request, clip);
  // Without a report the sounds are not kept.
  std::optional<TemporaryFolder> passing;
  if (request.report) {
    create_folder(*request.report);
  } else {
    passing.emplace();
  }
  const fs::path folder = request.report ? *request.report : passing->path();
  const std::unique_ptr<PeopleDetector> detector = detector_named(request.detector, !request.quiet);
  const EarpointComparison comparison = compare_earpoints(
      clip, methods, folder,
      {.estimator = request.estimator, .threads = request.threads, .detector = detector.get()},
      progress);
  if (request.report) write_earpoint_page(comparison, *request.report);
  if (request.figure) {
    draw_figure(*request.figure, comparison, folder, request.threads, progress);
  }
  fmt::print("{}", request.json ? json_of(comparison) : text_of(comparison));
}

}  // namespace earpoint

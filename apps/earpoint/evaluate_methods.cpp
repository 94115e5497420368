#include "evaluate_methods.h"

#include "arguments.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/evaluate/oracles.h>
#include <earpoint/evaluate/transfer_function.h>
#include <earpoint/network/model_names.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

// What `earpoint train` leaves in the folder of a run.
constexpr const char* kBestWeights = "best.safetensors";

MethodEntry transfer_function(const MethodRequest& request, const std::set<std::string>& scenes) {
  const TransferIndex index = request.tf_index == "locations" ? TransferIndex::locations
                              : request.tf_index == "relative"
                                  ? TransferIndex::relative_pose
                                  : transfer_index_for(request.data, request.layout, scenes);
  return transfer_function_method(request.data, request.layout, index);
}

/// Splits MODEL:TEXTURE into the model and the texture.
std::pair<std::string, std::optional<double>> split_texture(const std::string& word) {
  const std::size_t colon = word.rfind(':');
  if (colon == std::string::npos) return {word, {}};
  const std::optional<double> texture = texture_of(word.substr(colon + 1));
  return {texture ? word.substr(0, colon) : word, texture};
}

MethodEntry method_of(const std::string& word, const MethodRequest& request,
                      const std::set<std::string>& scenes) {
  if (word == "input") return input_method();
  if (request.layout == DatasetLayout::rwavs && word != "dsp") {
    throw InputError("--methods " + word,
                     "RWAVS has dry sound and positions, but no source view: only input and dsp "
                     "take these",
                     "leave it out");
  }
  if (request.enhance && (word == "dsp" || word == "tf")) {
    throw InputError("--methods " + word, "renders the sound at a position, not dry speech",
                     "leave it out with --enhance");
  }
  if (!request.knows_speaker && word == "tf") {
    throw InputError("--methods tf",
                     "needs the speakers' positions, which these recordings do not have",
                     "leave it out");
  }
  if (word == "dsp") return dsp_method();
  if (word == "tf") return transfer_function(request, scenes);
  for (MethodEntry& oracle : oracle_methods()) {
    if (word == oracle.name) return std::move(oracle);
  }
  const auto [model, texture] = split_texture(word);
  SynthesizerOptions options;
  options.texture = texture;
  options.enhances = request.enhance;
  if (const auto equals = model.find('='); equals != std::string::npos) {
    if (equals == 0 || equals + 1 == model.size()) {
      throw InputError("--methods " + word, "expected NAME=FILE");
    }
    return network_method(model.substr(0, equals) + word.substr(model.size()),
                          model.substr(equals + 1), options);
  }
  if (const auto path = shipped_model(model)) {
    return network_method(word, path->string(), options);
  }
  throw InputError("--methods " + word, "is neither a known method nor a shipped model",
                   "name a weight file: " + word + "=FILE.safetensors");
}

/// NAME=FILE of every run in a folder, in the order of names.
std::vector<std::string> runs_in(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> words;
  for (const fs::directory_entry& run : fs::directory_iterator(folder, error)) {
    const fs::path weights = run.path() / kBestWeights;
    if (fs::exists(weights))
      words.push_back(run.path().filename().string() + "=" + weights.string());
  }
  if (error) throw InputError("--runs " + folder.string(), error.message());
  if (words.empty()) {
    throw InputError("--runs " + folder.string(),
                     fmt::format("holds no run: no folder in it has a {}", kBestWeights),
                     "train one (earpoint train)");
  }
  std::ranges::sort(words);
  return words;
}

/// The names of all shipped models of the families that are ablated: NAME and NAME-*.
std::vector<std::string> shipped_families() {
  std::vector<std::string> words = shipped_model_names({"gtf", "vigas"});
  if (words.empty()) {
    throw InputError("--ablations",
                     "neither gtf.safetensors nor vigas.safetensors is among the shipped models",
                     "give the folder of your own runs with --runs");
  }
  return words;
}

std::vector<std::string> words_of(const MethodRequest& request) {
  std::vector<std::string> words =
      request.ablations ? std::vector<std::string>{"input"} : request.words;
  const auto add = [&](const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
  };
  if (request.runs) {
    add(runs_in(*request.runs));
  } else if (request.ablations) {
    add(shipped_families());
  }
  if (!request.oracles || request.layout == DatasetLayout::rwavs) return words;
  for (const MethodEntry& oracle : oracle_methods()) {
    if (request.recorded && oracle.needs_truth) continue;
    if (std::ranges::find(words, oracle.name) == words.end()) words.push_back(oracle.name);
  }
  return words;
}

}  // namespace

std::vector<MethodEntry> methods_of(const MethodRequest& request,
                                    const std::set<std::string>& scenes) {
  std::vector<MethodEntry> methods;
  for (const std::string& word : words_of(request)) {
    MethodEntry method = method_of(word, request, scenes);
    if (std::ranges::find(methods, method.name, &MethodEntry::name) != methods.end()) {
      throw InputError("--methods", "names " + method.name + " twice", "give one NAME=FILE");
    }
    methods.push_back(std::move(method));
  }
  return methods;
}

}  // namespace earpoint

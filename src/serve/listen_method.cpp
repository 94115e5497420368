#include <earpoint/serve/listen_method.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/network/model_names.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/render/head_file.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/spatial/sofa_file.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

ListenMethod network(std::string name, const std::string& file) {
  ListenMethod method{.name = std::move(name), .model = file};
  if (!fs::exists(file)) throw InputError("methods " + file, "there is no such file");
  // The bytes are kept: a training run may replace the file while it is served.
  std::vector<std::byte> bytes = read_file(file);
  SafetensorsFile weights = parse_safetensors(bytes, file);
  if (network_kind(weights, file) == NetworkKind::gtf) {
    method.gtf = std::make_shared<const GtfWeights>(gtf_weights(std::move(weights), file));
    method.engine_model = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  } else {
    // A bad file is found before anything is served.
    method.needs_box = make_synthesizer(file, {})->picture_use() == PictureUse::always;
  }
  return method;
}

ListenMethod method_of(const std::string& word) {
  if (word == "input") return {.name = word, .model = word};
  if (word == "dsp") {
    (void)make_synthesizer(word, {});
    const fs::path head = default_hrtf_path();
    const auto file = std::make_shared<const std::vector<std::byte>>(
        serialize_safetensors(to_head_file(read_sofa(head)), head.string()));
    return {.name = word, .model = word, .engine_model = file, .needs_speaker = true};
  }
  if (const auto equals = word.find('='); equals != std::string::npos) {
    if (equals == 0 || equals + 1 == word.size() || word.substr(0, equals) == kTruthName) {
      throw InputError("methods " + word, "expected NAME=FILE");
    }
    return network(word.substr(0, equals), word.substr(equals + 1));
  }
  if (const auto shipped = shipped_model(word)) {
    return network(word, shipped->string());
  }
  throw InputError("methods " + word, "is neither a known method nor a shipped model",
                   "name a weight file: NAME=FILE.safetensors");
}

bool has_head_filters() {
  try {
    (void)default_hrtf_path();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

std::vector<ListenMethod> listen_methods(std::span<const std::string> words) {
  std::vector<ListenMethod> methods;
  for (const std::string& word : words) {
    ListenMethod method = method_of(word);
    if (std::ranges::find(methods, method.name, &ListenMethod::name) != methods.end()) {
      throw InputError("methods", "names " + method.name + " twice", "give one NAME=FILE");
    }
    methods.push_back(std::move(method));
  }
  if (methods.empty()) throw InputError("methods", "names nothing to listen to");
  return methods;
}

std::vector<std::string> default_listen_words() {
  std::vector<std::string> words{"input"};
  if (has_head_filters()) words.emplace_back("dsp");
  if (!shipped_model("gtf")) return words;
  const std::vector<std::string> models = shipped_model_names({"gtf", "vam", "vigas"});
  words.insert(words.end(), models.begin(), models.end());
  return words;
}

}  // namespace earpoint

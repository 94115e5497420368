#include "evaluate_methods.h"

#include <algorithm>

#include <earpoint/core/error.h>
#include <earpoint/model/shipped_model.h>

namespace {

using earpoint::InputError;
using earpoint::MethodEntry;

MethodEntry method_of(const std::string& word) {
  if (word == "input") return earpoint::input_method();
  if (word == "dsp") return earpoint::dsp_method();
  if (const auto equals = word.find('='); equals != std::string::npos) {
    if (equals == 0 || equals + 1 == word.size()) {
      throw InputError("--methods " + word, "expected NAME=FILE");
    }
    return earpoint::network_method(word.substr(0, equals), word.substr(equals + 1));
  }
  if (const auto path = earpoint::shipped_model_path(word + ".safetensors")) {
    return earpoint::network_method(word, path->string());
  }
  throw InputError("--methods " + word, "is neither a known method nor a model that is there",
                   "name a weight file: " + word + "=FILE.safetensors");
}

}  // namespace

std::vector<MethodEntry> methods_of(const std::vector<std::string>& words) {
  std::vector<MethodEntry> methods;
  for (const std::string& word : words) {
    MethodEntry method = method_of(word);
    if (std::ranges::find(methods, method.name, &MethodEntry::name) != methods.end()) {
      throw InputError("--methods", "names " + method.name + " twice", "give one NAME=FILE");
    }
    methods.push_back(std::move(method));
  }
  return methods;
}

#include "evaluate_methods.h"

#include <algorithm>

#include <earpoint/core/error.h>
#include <earpoint/evaluate/oracles.h>
#include <earpoint/evaluate/transfer_function.h>
#include <earpoint/model/shipped_model.h>

namespace {

using earpoint::InputError;
using earpoint::MethodEntry;
using earpoint::TransferIndex;

MethodEntry transfer_function(const MethodRequest& request, const std::set<std::string>& scenes) {
  const TransferIndex index = request.tf_index == "locations" ? TransferIndex::locations
                              : request.tf_index == "relative"
                                  ? TransferIndex::relative_pose
                                  : earpoint::transfer_index_for(request.data, scenes);
  return earpoint::transfer_function_method(request.data, index);
}

MethodEntry method_of(const std::string& word, const MethodRequest& request,
                      const std::set<std::string>& scenes) {
  if (word == "input") return earpoint::input_method();
  if (word == "dsp") return earpoint::dsp_method();
  if (word == "tf") return transfer_function(request, scenes);
  for (MethodEntry& oracle : earpoint::oracle_methods()) {
    if (word == oracle.name) return std::move(oracle);
  }
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

std::vector<MethodEntry> methods_of(const MethodRequest& request,
                                    const std::set<std::string>& scenes) {
  std::vector<std::string> words = request.words;
  if (request.oracles) {
    for (const MethodEntry& oracle : earpoint::oracle_methods()) {
      if (std::ranges::find(words, oracle.name) == words.end()) words.push_back(oracle.name);
    }
  }
  std::vector<MethodEntry> methods;
  for (const std::string& word : words) {
    MethodEntry method = method_of(word, request, scenes);
    if (std::ranges::find(methods, method.name, &MethodEntry::name) != methods.end()) {
      throw InputError("--methods", "names " + method.name + " twice", "give one NAME=FILE");
    }
    methods.push_back(std::move(method));
  }
  return methods;
}

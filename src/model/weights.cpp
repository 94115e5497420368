#include "checked_tensors.h"
#include "quote.h"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/error.h>
#include <earpoint/model/strict_json.h>
#include <earpoint/model/weights.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;
std::string json_of(const std::map<std::string, HyperParameter>& hparams) {
  Json json = Json::object();
  for (const auto& [name, value] : hparams) {
    std::visit([&json, &key = name](const auto& v) { json[key] = v; }, value);
  }
  return json.dump();
}

}  // namespace

NetworkKind network_kind(const SafetensorsFile& file, std::string_view where) {
  constexpr int kDepth = 3;
  const std::string here = where_described(where);
  const Json json = parse_strict_json(description_of(file, where), here, kDepth);
  const std::string network = JsonObjectReader(json, here).string("network");
  if (network == "vigas") return NetworkKind::vigas;
  if (network == "gtf") return NetworkKind::gtf;
  if (network == "rt60_estimator") return NetworkKind::rt60_estimator;
  if (network == "vam") return NetworkKind::vam;
  if (network == "people") return NetworkKind::people;
  throw InputError(
      here, fmt::format("'network': expected 'vigas', 'gtf', 'vam', 'rt60_estimator' or 'people', "
                        "found {}",
                        in_quotes(network)));
}

const Tensor& ViGasWeights::at(const std::string& name) const { return tensor_at(tensors, name); }

ViGasWeights vigas_weights(SafetensorsFile file, std::string_view where) {
  ViGasWeights weights;
  weights.description =
      vigas_description_from_json(description_of(file, where), where_described(where));
  weights.tensors = take_required(file.tensors, required_tensors(weights.description), where);
  weights.unused = names_of(file.tensors);
  return weights;
}

ViGasWeights read_vigas_weights(const std::filesystem::path& path) {
  return vigas_weights(read_safetensors(path), path.string());
}

SafetensorsFile vigas_weight_file(const ViGasWeights& weights,
                                  std::map<std::string, std::string> metadata) {
  SafetensorsFile file{weights.tensors, std::move(metadata)};
  file.metadata[std::string(kDescriptionKey)] = to_json(weights.description);
  return file;
}

SafetensorsFile weight_file_from_checkpoint(Checkpoint checkpoint, KeepTensors keep,
                                            std::string_view where) {
  const bool estimator = checkpoint.state_dict.contains("feature_extraction.0.weight");
  std::string description;
  TensorShapes shapes;
  if (estimator) {
    const Rt60Description released;
    description = to_json(released);
    shapes = required_tensors(released);
  } else {
    const ViGasDescription vigas = describe_vigas(checkpoint, where);
    description = to_json(vigas);
    shapes = required_tensors(vigas);
  }

  SafetensorsFile file;
  file.tensors = take_required(checkpoint.state_dict, shapes, where);
  file.metadata[std::string(kDescriptionKey)] = std::move(description);
  if (!checkpoint.hparams.empty()) {
    file.metadata["earpoint.hparams"] = json_of(checkpoint.hparams);
  }
  if (keep == KeepTensors::all) {
    file.tensors.merge(checkpoint.state_dict);
  } else if (!checkpoint.state_dict.empty()) {
    file.metadata["earpoint.dropped_tensors"] =
        fmt::format("{}", fmt::join(names_of(checkpoint.state_dict), " "));
  }
  return file;
}

}  // namespace earpoint

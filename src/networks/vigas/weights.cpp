#include <earpoint/vigas/weights.h>

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <earpoint/network/checked_tensors.h>
#include <earpoint/rt60/description.h>

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

ViGasWeights vigas_weights(SafetensorsFile file, std::string_view where) {
  return checked_weights(std::move(file), where, vigas_description_from_json);
}

ViGasWeights read_vigas_weights(const std::filesystem::path& path) {
  return vigas_weights(read_safetensors(path), path.string());
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

#include "quote.h"

#include <algorithm>
#include <cmath>
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
using Tensors = std::map<std::string, Tensor>;
using Shapes = std::map<std::string, std::vector<std::int64_t>>;

constexpr std::string_view kRt60Description =
    R"({"format":1,"network":"rt60_estimator","sample_rate_hz":16000})";

const std::string& description_of(const SafetensorsFile& file, std::string_view where) {
  const auto found = file.metadata.find(std::string(kDescriptionKey));
  if (found == file.metadata.end()) {
    throw InputError(where, fmt::format("has no metadata '{}'", kDescriptionKey),
                     "make it with earpoint model import");
  }
  return found->second;
}

std::string where_described(std::string_view where) {
  return fmt::format("{}: metadata '{}'", where, kDescriptionKey);
}

/// Checks one tensor and widens it to float32.
void check_tensor(Tensor& tensor, const std::vector<std::int64_t>& shape, std::string_view where) {
  const bool real = tensor.dtype == DType::f32 || tensor.dtype == DType::f64 ||
                    tensor.dtype == DType::f16 || tensor.dtype == DType::bf16;
  if (!real || tensor.shape != shape) {
    throw InputError(where, fmt::format("expected F32 {}, found {} {}", to_string(shape),
                                        name_of(tensor.dtype), to_string(tensor.shape)));
  }
  if (tensor.dtype != DType::f32) tensor = to_float32(tensor);
  const auto values = tensor.as<float>();
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) {
    throw InputError(where, "has NaN or infinite values");
  }
  // A square root is taken of it.
  if (where.find(".running_var'") != std::string_view::npos &&
      std::any_of(values.begin(), values.end(), [](float v) { return v < 0; })) {
    throw InputError(where, "is a variance but has negative values");
  }
}

/// Moves the required tensors out of `from`, checked; what stays is not read by inference.
Tensors take_required(Tensors& from, const Shapes& shapes, std::string_view where) {
  Tensors taken;
  for (const auto& [name, shape] : shapes) {
    auto node = from.extract(name);
    if (node.empty()) {
      throw InputError(where,
                       fmt::format("has no tensor '{}' of shape {}", name, to_string(shape)));
    }
    check_tensor(node.mapped(), shape, fmt::format("{}: tensor '{}'", where, name));
    taken.insert(std::move(node));
  }
  return taken;
}

std::vector<std::string> names_of(const Tensors& tensors) {
  std::vector<std::string> names;
  names.reserve(tensors.size());
  for (const auto& [name, tensor] : tensors) names.push_back(name);
  return names;
}

const Tensor& tensor_at(const Tensors& tensors, const std::string& name) {
  const auto found = tensors.find(name);
  if (found == tensors.end()) throw std::logic_error("no weights named " + name);
  return found->second;
}

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
  if (network == "rt60_estimator") return NetworkKind::rt60_estimator;
  throw InputError(here, fmt::format("'network': expected 'vigas' or 'rt60_estimator', found {}",
                                     in_quotes(network)));
}

const Tensor& ViGasWeights::at(const std::string& name) const { return tensor_at(tensors, name); }

const Tensor& Rt60EstimatorWeights::at(const std::string& name) const {
  return tensor_at(tensors, name);
}

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

Rt60EstimatorWeights rt60_estimator_weights(SafetensorsFile file, std::string_view where) {
  const std::string& description = description_of(file, where);
  const std::string here = where_described(where);
  if (parse_strict_json(description, here, 1) != Json::parse(kRt60Description)) {
    throw InputError(
        here, fmt::format("expected {}, found {}", kRt60Description, in_quotes(description)));
  }
  Rt60EstimatorWeights weights;
  weights.tensors = take_required(file.tensors, required_rt60_tensors(), where);
  weights.unused = names_of(file.tensors);
  return weights;
}

Rt60EstimatorWeights read_rt60_estimator_weights(const std::filesystem::path& path) {
  return rt60_estimator_weights(read_safetensors(path), path.string());
}

SafetensorsFile weight_file_from_checkpoint(Checkpoint checkpoint, KeepTensors keep,
                                            std::string_view where) {
  const bool estimator = checkpoint.state_dict.contains("feature_extraction.0.weight");
  std::string description;
  Shapes shapes;
  if (estimator) {
    description = kRt60Description;
    shapes = required_rt60_tensors();
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

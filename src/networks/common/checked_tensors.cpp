#include <earpoint/network/checked_tensors.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/quote.h>
#include <earpoint/error.h>
#include <earpoint/network/network_kind.h>

namespace earpoint {
namespace {

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

}  // namespace

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

NamedTensors take_required(NamedTensors& from, const TensorShapes& shapes, std::string_view where) {
  NamedTensors taken;
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

std::vector<std::string> names_of(const NamedTensors& tensors) {
  std::vector<std::string> names;
  names.reserve(tensors.size());
  for (const auto& [name, tensor] : tensors) names.push_back(name);
  return names;
}

const Tensor& tensor_at(const NamedTensors& tensors, const std::string& name) {
  const auto found = tensors.find(name);
  if (found == tensors.end()) throw std::logic_error("no weights named " + name);
  return found->second;
}

}  // namespace earpoint

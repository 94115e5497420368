#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <earpoint/network/checked_tensors.h>
#include <earpoint/weights/safetensors.h>
#include <earpoint/weights/tensor.h>

namespace earpoint {

/// The weights of one network, every tensor checked.
template <class Description>
struct NetworkWeights {
  Description description;
  /// Exactly those that required_tensors(description) names, float32, all finite.
  std::map<std::string, Tensor> tensors;
  /// Names of tensors that the file has and inference does not read, e.g. other output heads.
  std::vector<std::string> unused;

  /// @throws std::logic_error if no required tensor has that name
  [[nodiscard]] const Tensor& at(const std::string& name) const { return tensor_at(tensors, name); }
};

/// Takes a network out of a weight file; F16, BF16 and F64 tensors become float32.
/// @param where      the file, for messages
/// @param from_json  reads the network's description
/// @throws InputError if the description is wrong, or a tensor is missing, has another shape than
///         the description asks for, is not of floating point or holds NaN or infinity
template <class Description>
[[nodiscard]] NetworkWeights<Description> checked_weights(
    SafetensorsFile file, std::string_view where,
    Description (*from_json)(std::string_view json, std::string_view where)) {
  NetworkWeights<Description> weights;
  weights.description = from_json(description_of(file, where), where_described(where));
  weights.tensors = take_required(file.tensors, required_tensors(weights.description), where);
  weights.unused = names_of(file.tensors);
  return weights;
}

/// A weight file that checked_weights() reads back. `metadata` is written beside the description.
template <class Description>
[[nodiscard]] SafetensorsFile to_weight_file(const NetworkWeights<Description>& weights,
                                             std::map<std::string, std::string> metadata = {}) {
  metadata[std::string(kDescriptionKey)] = to_json(weights.description);
  return {weights.tensors, std::move(metadata)};
}

}  // namespace earpoint

#include "checked_tensors.h"

#include <utility>

#include <earpoint/model/weights.h>

namespace earpoint {

const Tensor& Rt60EstimatorWeights::at(const std::string& name) const {
  return tensor_at(tensors, name);
}

Rt60EstimatorWeights rt60_estimator_weights(SafetensorsFile file, std::string_view where) {
  Rt60EstimatorWeights weights;
  weights.description =
      rt60_description_from_json(description_of(file, where), where_described(where));
  weights.tensors = take_required(file.tensors, required_tensors(weights.description), where);
  weights.unused = names_of(file.tensors);
  return weights;
}

Rt60EstimatorWeights read_rt60_estimator_weights(const std::filesystem::path& path) {
  return rt60_estimator_weights(read_safetensors(path), path.string());
}

SafetensorsFile rt60_weight_file(const Rt60EstimatorWeights& weights,
                                 std::map<std::string, std::string> metadata) {
  SafetensorsFile file{weights.tensors, std::move(metadata)};
  file.metadata[std::string(kDescriptionKey)] = to_json(weights.description);
  return file;
}

}  // namespace earpoint

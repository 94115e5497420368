#include "checked_tensors.h"

#include <utility>

#include <earpoint/model/vam.h>
#include <earpoint/model/weights.h>

namespace earpoint {

const Tensor& VamWeights::at(const std::string& name) const { return tensor_at(tensors, name); }

VamWeights vam_weights(SafetensorsFile file, std::string_view where) {
  VamWeights weights;
  weights.description =
      vam_description_from_json(description_of(file, where), where_described(where));
  weights.tensors = take_required(file.tensors, required_tensors(weights.description), where);
  weights.unused = names_of(file.tensors);
  return weights;
}

VamWeights read_vam_weights(const std::filesystem::path& path) {
  return vam_weights(read_safetensors(path), path.string());
}

SafetensorsFile vam_weight_file(const VamWeights& weights,
                                std::map<std::string, std::string> metadata) {
  SafetensorsFile file{weights.tensors, std::move(metadata)};
  file.metadata[std::string(kDescriptionKey)] = to_json(weights.description);
  return file;
}

}  // namespace earpoint

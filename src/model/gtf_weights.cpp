#include "checked_tensors.h"

#include <utility>

#include <earpoint/model/gtf.h>
#include <earpoint/model/weights.h>

namespace earpoint {

const Tensor& GtfWeights::at(const std::string& name) const { return tensor_at(tensors, name); }

GtfWeights gtf_weights(SafetensorsFile file, std::string_view where) {
  GtfWeights weights;
  weights.description =
      gtf_description_from_json(description_of(file, where), where_described(where));
  weights.tensors = take_required(file.tensors, required_tensors(weights.description), where);
  weights.unused = names_of(file.tensors);
  return weights;
}

GtfWeights read_gtf_weights(const std::filesystem::path& path) {
  return gtf_weights(read_safetensors(path), path.string());
}

SafetensorsFile gtf_weight_file(const GtfWeights& weights,
                                std::map<std::string, std::string> metadata) {
  SafetensorsFile file{weights.tensors, std::move(metadata)};
  file.metadata[std::string(kDescriptionKey)] = to_json(weights.description);
  return file;
}

}  // namespace earpoint

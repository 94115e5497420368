#include "checked_tensors.h"

#include <utility>

#include <earpoint/model/people.h>
#include <earpoint/model/weights.h>

namespace earpoint {

const Tensor& PeopleWeights::at(const std::string& name) const { return tensor_at(tensors, name); }

PeopleWeights people_weights(SafetensorsFile file, std::string_view where) {
  PeopleWeights weights;
  weights.description =
      people_description_from_json(description_of(file, where), where_described(where));
  weights.tensors = take_required(file.tensors, required_tensors(weights.description), where);
  weights.unused = names_of(file.tensors);
  return weights;
}

PeopleWeights read_people_weights(const std::filesystem::path& path) {
  return people_weights(read_safetensors(path), path.string());
}

SafetensorsFile people_weight_file(const PeopleWeights& weights,
                                   std::map<std::string, std::string> metadata) {
  SafetensorsFile file{weights.tensors, std::move(metadata)};
  file.metadata[std::string(kDescriptionKey)] = to_json(weights.description);
  return file;
}

}  // namespace earpoint

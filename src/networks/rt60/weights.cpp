#include <earpoint/rt60/weights.h>

#include <utility>

namespace earpoint {

Rt60EstimatorWeights rt60_estimator_weights(SafetensorsFile file, std::string_view where) {
  return checked_weights(std::move(file), where, rt60_description_from_json);
}

Rt60EstimatorWeights read_rt60_estimator_weights(const std::filesystem::path& path) {
  return rt60_estimator_weights(read_safetensors(path), path.string());
}

}  // namespace earpoint

#include <earpoint/gtf/weights.h>

#include <utility>

namespace earpoint {

GtfWeights gtf_weights(SafetensorsFile file, std::string_view where) {
  return checked_weights(std::move(file), where, gtf_description_from_json);
}

GtfWeights read_gtf_weights(const std::filesystem::path& path) {
  return gtf_weights(read_safetensors(path), path.string());
}

}  // namespace earpoint

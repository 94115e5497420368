#include <earpoint/vam/weights.h>

#include <utility>

namespace earpoint {

VamWeights vam_weights(SafetensorsFile file, std::string_view where) {
  return checked_weights(std::move(file), where, vam_description_from_json);
}

VamWeights read_vam_weights(const std::filesystem::path& path) {
  return vam_weights(read_safetensors(path), path.string());
}

}  // namespace earpoint

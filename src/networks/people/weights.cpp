#include <earpoint/people/weights.h>

#include <utility>

namespace earpoint {

PeopleWeights people_weights(SafetensorsFile file, std::string_view where) {
  return checked_weights(std::move(file), where, people_description_from_json);
}

PeopleWeights read_people_weights(const std::filesystem::path& path) {
  return people_weights(read_safetensors(path), path.string());
}

}  // namespace earpoint

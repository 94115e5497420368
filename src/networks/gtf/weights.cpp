#include <earpoint/gtf/weights.h>

#include <optional>
#include <utility>

#include <fmt/format.h>

namespace earpoint {

GtfWeights gtf_weights(SafetensorsFile file, std::string_view where) {
  std::optional<GtfTrainingRange> range;
  if (const auto found = file.metadata.find(std::string(kTrainingRangeKey));
      found != file.metadata.end()) {
    range = gtf_training_range_from_json(
        found->second, fmt::format("{}: metadata '{}'", where, kTrainingRangeKey));
  }
  GtfWeights weights = checked_weights(std::move(file), where, gtf_description_from_json);
  if (range) weights.description.training_range = *range;
  return weights;
}

SafetensorsFile to_weight_file(const GtfWeights& weights,
                               std::map<std::string, std::string> metadata) {
  metadata[std::string(kTrainingRangeKey)] = to_json(weights.description.training_range);
  return to_weight_file<GtfDescription>(weights, std::move(metadata));
}

GtfWeights read_gtf_weights(const std::filesystem::path& path) {
  return gtf_weights(read_safetensors(path), path.string());
}

}  // namespace earpoint

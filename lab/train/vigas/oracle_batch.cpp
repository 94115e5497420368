#include "oracle_batch.h"

#include <cstdlib>
#include <string>
#include <vector>

namespace earpoint {
namespace {

std::vector<float> floats(const SafetensorsFile& file, const std::string& name) {
  const auto values = file.tensors.at(name).as<float>();
  return {values.begin(), values.end()};
}

}  // namespace

TrainingBatch oracle_batch(const SafetensorsFile& file, const ViGasDescription& description) {
  TrainingBatch batch;
  batch.clips = file.tensors.at("src_wav").shape[0];
  batch.source = floats(file, "src_wav");
  if (file.tensors.contains("tgt_wav")) batch.target = floats(file, "tgt_wav");
  for (const ConditioningInput& input : description.inputs) {
    if (input.name == "visual_feat" && description.image_encoder) {
      for (const std::uint8_t byte : file.tensors.at("src_rgb_u8").as<std::uint8_t>()) {
        batch.pictures.push_back(static_cast<float>(byte) / 255.0F);
      }
    } else {
      batch.inputs[input.name] = floats(file, input.name);
    }
  }
  return batch;
}

std::filesystem::path oracle_folder() {
  const char* folder = std::getenv("EARPOINT_ORACLE_DIR");
  return folder == nullptr ? std::filesystem::path() : std::filesystem::path(folder);
}

}  // namespace earpoint

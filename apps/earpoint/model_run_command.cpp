#include "model_run_command.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/vigas/engine.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNotes = R"(
Inputs, all F32 with the clips of a batch along the first axis:
  src_wav       [clips, channels, samples], any number of samples
  src_rgb_u8    [clips, 3, height, width], U8; or src_rgb, F32, 0 to 1; or visual_feat,
                which is the only choice for networks without an image encoder
  tgt_pose, tgt_rotation, bboxes, ...   [clips, numbers], those that earpoint model info lists
Outputs: pred, of the shape of src_wav; fused; visual_feat.
)";

struct RunOptions {
  fs::path weights;
  fs::path inputs;
  fs::path output;
  int threads = available_cores();
};

/// The inputs of all clips, checked.
struct Batch {
  std::int64_t clips = 0;
  std::int64_t samples = 0;
  std::map<std::string, std::span<const float>> values;  ///< by name, all clips
  std::span<const std::uint8_t> picture_bytes;           ///< src_rgb_u8, if there is one
};

std::span<const float> expect_floats(const SafetensorsFile& file, const std::string& where,
                                     const std::string& name,
                                     std::initializer_list<std::int64_t> shape) {
  const Tensor& tensor = expect_tensor(file, where, name, DType::f32, shape);
  const auto values = tensor.as<float>();
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) {
    throw InputError(fmt::format("{}: tensor '{}'", where, name), "has NaN or infinite values");
  }
  return values;
}

/// The name of the tensor that gives the picture.
std::string picture_tensor(const SafetensorsFile& file, const std::string& where,
                           bool has_encoder) {
  if (!has_encoder) return "visual_feat";
  std::vector<std::string> found;
  for (const char* name : {"src_rgb_u8", "src_rgb", "visual_feat"}) {
    if (file.tensors.contains(name)) found.emplace_back(name);
  }
  if (found.size() == 1) return found[0];
  throw InputError(where, fmt::format("expected one of the tensors 'src_rgb_u8', 'src_rgb' and "
                                      "'visual_feat', found {}",
                                      found.empty() ? "none" : "more"));
}

Batch check_inputs(const SafetensorsFile& file, const std::string& where,
                   const ViGasDescription& network) {
  Batch batch;
  batch.values["src_wav"] =
      expect_floats(file, where, "src_wav", {kAnySize, network.audio_channels, kAnySize});
  const auto& shape = file.tensors.at("src_wav").shape;
  batch.clips = shape[0];
  batch.samples = shape[2];
  if (batch.clips == 0 || batch.samples == 0) {
    throw InputError(
        fmt::format("{}: tensor 'src_wav'", where),
        fmt::format("expected at least one clip of one sample, found {}", to_string(shape)));
  }
  for (const ConditioningInput& input : network.inputs) {
    if (input.name != "visual_feat") {
      batch.values[input.name] = expect_floats(file, where, input.name, {batch.clips, input.width});
      continue;
    }
    const std::string name = picture_tensor(file, where, network.image_encoder.has_value());
    if (name == "visual_feat") {
      batch.values[name] = expect_floats(file, where, name, {batch.clips, input.width});
      continue;
    }
    const std::int64_t height = network.image_encoder->height_px;
    const std::int64_t width = network.image_encoder->width_px;
    if (name == "src_rgb") {
      batch.values[name] = expect_floats(file, where, name, {batch.clips, 3, height, width});
    } else {
      batch.picture_bytes =
          expect_tensor(file, where, name, DType::u8, {batch.clips, 3, height, width})
              .as<std::uint8_t>();
    }
  }
  return batch;
}

/// The part of one clip.
template <typename T>
std::span<T> of_clip(std::span<T> values, const Batch& batch, std::int64_t clip) {
  const std::size_t size = values.size() / batch.clips;
  return values.subspan(clip * size, size);
}

std::vector<float> visual_feature(ViGas& network, const Batch& batch, std::int64_t clip) {
  if (const auto given = batch.values.find("visual_feat"); given != batch.values.end()) {
    const auto feature = of_clip(given->second, batch, clip);
    return {feature.begin(), feature.end()};
  }
  if (const auto given = batch.values.find("src_rgb"); given != batch.values.end()) {
    return network.image_feature(of_clip(given->second, batch, clip));
  }
  std::vector<float> picture;
  for (const std::uint8_t byte : of_clip(batch.picture_bytes, batch, clip)) {
    picture.push_back(static_cast<float>(byte) / 255.0F);
  }
  return network.image_feature(picture);
}

SafetensorsFile run_batch(ViGas& network, const Batch& batch) {
  const ViGasDescription& description = network.description();
  std::vector<float> predictions(batch.values.at("src_wav").size());
  std::vector<float> all_fused(batch.clips * description.conditioning_width);
  std::vector<float> features;
  for (std::int64_t clip = 0; clip < batch.clips; ++clip) {
    std::vector<float> feature;
    std::vector<ConditioningValues> inputs;
    for (const ConditioningInput& input : description.inputs) {
      if (input.name == "visual_feat") {
        feature = visual_feature(network, batch, clip);
        features.insert(features.end(), feature.begin(), feature.end());
        inputs.push_back({input.name, feature});
      } else {
        inputs.push_back({input.name, of_clip(batch.values.at(input.name), batch, clip)});
      }
    }
    const std::span<float> fused = of_clip(std::span(all_fused), batch, clip);
    network.fuse(inputs, fused);
    network.synthesize(of_clip(batch.values.at("src_wav"), batch, clip), fused,
                       of_clip(std::span(predictions), batch, clip));
  }

  SafetensorsFile outputs;
  const auto add = [&](const char* name, const std::vector<float>& values,
                       std::vector<std::int64_t> shape) {
    outputs.tensors.emplace(name, make_tensor<float>(values, std::move(shape)));
  };
  add("pred", predictions, {batch.clips, description.audio_channels, batch.samples});
  add("fused", all_fused, {batch.clips, description.conditioning_width});
  if (!features.empty()) {
    add("visual_feat", features,
        {batch.clips, static_cast<std::int64_t>(features.size()) / batch.clips});
  }
  return outputs;
}

void run_model(const RunOptions& options) {
  const ViGasWeights weights = read_vigas_weights(options.weights);
  const SafetensorsFile inputs = read_safetensors(options.inputs);
  const Batch batch = check_inputs(inputs, options.inputs.string(), weights.description);
  ViGas network(weights, options.threads);
  write_safetensors(options.output, run_batch(network, batch));
}

}  // namespace

void add_model_run_command(CLI::App& model) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command =
      model.add_subcommand("run", "Run a network on raw tensors and write its outputs.");
  command->footer(kNotes);
  command->add_option("weights", options->weights, "Weight file (.safetensors)")->required();
  command->add_option("inputs", options->inputs, "Input tensors (.safetensors)")->required();
  command->add_option("-o,--output", options->output, "Output tensors to write (.safetensors)")
      ->required();
  command->add_option("--threads", options->threads, "Number of threads; does not change results")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->callback([options] { run_model(*options); });
}

}  // namespace earpoint

#include "released_network.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <earpoint/network_testing/oracle_weights.h>
#include <earpoint/vigas/description.h>

namespace earpoint {
namespace {

Tensor draw(const std::string& name, std::vector<std::int64_t> shape, double lo, double hi) {
  const OracleRandom random(name, 1);
  std::vector<float> values(element_count(shape).value());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = random.value(i, lo, hi);
  return make_tensor<float>(values, std::move(shape));
}

/// Uniform weights with a variance of 1 / (number of inputs), larger in the output head, which gets
/// the mean of all layers; batch norms near identity.
Tensor draw_weights(const std::string& name, const std::vector<std::int64_t>& shape) {
  if (name.ends_with("running_var")) return draw(name, shape, 0.6, 1.6);
  if (shape.size() == 1) {
    return name.ends_with(".weight") ? draw(name, shape, 0.5, 1.0) : draw(name, shape, -0.1, 0.1);
  }
  std::int64_t inputs = 1;
  for (std::size_t i = 1; i < shape.size(); ++i) inputs *= shape[i];
  const double gain = name.starts_with("output_net") ? 4.0 : 1.0;
  const double most = gain * std::sqrt(3.0 / static_cast<double>(inputs));
  return draw(name, shape, -most, most);
}

}  // namespace

ViGasWeights drawn_network(const ViGasDescription& description) {
  check_description(description, "the network of the benchmark");
  ViGasWeights weights{description, {}, {}};
  for (const auto& [name, shape] : required_tensors(description)) {
    weights.tensors.emplace(name, draw_weights(name, shape));
  }
  return weights;
}

ViGasWeights released_network() {
  ViGasDescription network;
  network.image_encoder = ImageEncoderDescription{.width_px = 256, .height_px = 256, .channels = 8};
  network.highpass_cutoff_hz = 80.0;
  network.inputs = {{"visual_feat", network.image_encoder->feature_width()},
                    {"tgt_pose", 3},
                    {"tgt_rotation", 2},
                    {"bboxes", 4}};
  return drawn_network(network);
}

SafetensorsFile drawn_inputs(const ViGasDescription& network, std::int64_t clips) {
  SafetensorsFile inputs;
  const auto add = [&](const std::string& name, std::vector<std::int64_t> shape, double lo,
                       double hi) {
    inputs.tensors.emplace(name, draw(name, std::move(shape), lo, hi));
  };
  add("src_wav", {clips, network.audio_channels, network.window_samples}, -1.0, 1.0);
  for (const ConditioningInput& input : network.inputs) {
    if (input.name == "visual_feat" && network.image_encoder) {
      add("src_rgb", {clips, 3, network.image_encoder->height_px, network.image_encoder->width_px},
          0.0, 1.0);
    } else {
      add(input.name, {clips, input.width}, input.name == "bboxes" ? 0.0 : -1.0, 1.0);
    }
  }
  return inputs;
}

}  // namespace earpoint

#include <earpoint/vigas/engine.h>

#include "image_trunk.h"

#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/gated_stack.h>
#include <earpoint/network/picture_planes.h>
#include <earpoint/network/pose_encoding.h>

namespace earpoint {
namespace {

kernels::GatedLayerWeights layer_weights(const ViGasWeights& weights, int layer) {
  const ViGasDescription& d = weights.description;
  const auto values = [&](const char* name) {
    return weights.at(fmt::format("hyperconv_wavenet.layers.{}.{}", layer, name)).as<float>();
  };
  kernels::GatedLayerWeights of_layer;
  of_layer.convolution = {
      .taps = d.kernel_size, .dilation = d.dilation(layer), .acausal = d.acausal};
  of_layer.filter_weight = values("conv.w_f.weight");
  of_layer.filter_bias = values("conv.w_f.bias");
  of_layer.gate_weight = values("conv.w_g.weight");
  of_layer.gate_bias = values("conv.w_g.bias");
  of_layer.filter_conditioning_weight = values("conv.v_f.weight");
  of_layer.filter_conditioning_bias = values("conv.v_f.bias");
  of_layer.gate_conditioning_weight = values("conv.v_g.weight");
  of_layer.gate_conditioning_bias = values("conv.v_g.bias");
  if (layer + 1 < d.layers()) {
    of_layer.residual_weight = values("residual.weight");
    of_layer.residual_bias = values("residual.bias");
  }
  of_layer.skip_weight = values("skip.weight");
  of_layer.skip_bias = values("skip.bias");
  return of_layer;
}

kernels::GatedStackWeights stack_weights(const ViGasWeights& weights) {
  const ViGasDescription& d = weights.description;
  const auto values = [&](const std::string& name) { return weights.at(name).as<float>(); };
  kernels::GatedStackWeights stack;
  stack.audio_channels = d.audio_channels;
  stack.channels = d.channels;
  stack.conditioning_width = d.conditioning_width;
  stack.input_weight = values("input.weight");
  stack.input_bias = values("input.bias");
  for (int layer = 0; layer < d.layers(); ++layer) {
    stack.layers.push_back(layer_weights(weights, layer));
  }
  // There is an output head for every number of layers; only the last one is used.
  const std::string head = fmt::format("output_net.{}", d.layers() - 1);
  stack.first_weight = values(head + ".first.weight");
  stack.first_bias = values(head + ".first.bias");
  stack.second_weight = values(head + ".second.weight");
  stack.second_bias = values(head + ".second.bias");
  return stack;
}

kernels::Dense dense(const ViGasWeights& weights, const std::string& name) {
  return {weights.at(name + ".weight").as<float>(), weights.at(name + ".bias").as<float>()};
}

}  // namespace

struct ViGas::State {
  State(const ViGasWeights& weights, int threads)
      : description(weights.description),
        stack(stack_weights(weights), threads),
        fusion_hidden(dense(weights, "fusion.0")),
        fusion_output(dense(weights, "fusion.2")),
        joined(fusion_hidden.inputs()),
        hidden(fusion_hidden.outputs()) {
    if (description.image_encoder) trunk.emplace(weights, threads);
    stack.reserve(description.window_samples);
  }

  ViGasDescription description;
  std::optional<ImageTrunk> trunk;
  kernels::GatedStack stack;
  kernels::Dense fusion_hidden;
  kernels::Dense fusion_output;
  std::vector<float> joined;
  std::vector<float> hidden;
};

ViGas::ViGas(const ViGasWeights& weights, int threads)
    : state_(std::make_unique<State>(weights, threads)) {}
ViGas::~ViGas() = default;
ViGas::ViGas(ViGas&&) noexcept = default;
ViGas& ViGas::operator=(ViGas&&) noexcept = default;

const ViGasDescription& ViGas::description() const { return state_->description; }

std::vector<float> ViGas::image_feature(const Image& picture) {
  EARPOINT_CHECK(state_->trunk.has_value() && picture.channels() == 3 && !picture.empty());
  const ViGasDescription& description = state_->description;
  const ImageEncoderDescription& encoder = *description.image_encoder;
  if (description.pose_encoding != PoseEncoding::soundspaces) {
    return image_feature(picture_planes(picture, encoder.width_px, encoder.height_px));
  }
  // The loader of that data set divides first. It differs from picture_planes() in rounding alone.
  ImagePlanes planes = planes_of(picture);
  for (float& value : planes.values) value /= 255.0F;
  return image_feature(resize_bilinear(planes, encoder.width_px, encoder.height_px).values);
}

std::vector<float> ViGas::image_feature(std::span<const float> picture) {
  EARPOINT_CHECK(state_->trunk.has_value());
  std::vector<float> feature(state_->description.image_encoder->feature_width());
  state_->trunk->encode(picture, feature);
  return feature;
}

void ViGas::fuse(std::span<const ConditioningValues> inputs, std::span<float> fused) {
  State& state = *state_;
  EARPOINT_CHECK(inputs.size() == state.description.inputs.size());
  auto to = state.joined.begin();
  for (const ConditioningInput& expected : state.description.inputs) {
    const auto given =
        std::find_if(inputs.begin(), inputs.end(),
                     [&](const ConditioningValues& input) { return input.name == expected.name; });
    EARPOINT_CHECK(given != inputs.end() && std::ssize(given->values) == expected.width);
    to = std::copy(given->values.begin(), given->values.end(), to);
  }
  EARPOINT_CHECK(to == state.joined.end());
  state.fusion_hidden.apply(state.joined, state.hidden);
  kernels::apply_relu(state.hidden);
  state.fusion_output.apply(state.hidden, fused);
}

void ViGas::synthesize(std::span<const float> source, std::span<const float> fused,
                       std::span<float> output) {
  state_->stack.run(source, fused, output);
}

}  // namespace earpoint

#include "graph.h"

#include <cstdint>
#include <cstdlib>

#include <ATen/TensorOperators.h>
#include <ATen/ops/baddbmm.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/conv2d.h>
#include <ATen/ops/linear.h>
#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

/// Output t reads x[t + offset], zeros beyond the ends. |offset| is less than the samples.
at::Tensor shifted(const at::Tensor& x, std::int64_t offset) {
  if (offset == 0) return x;
  const std::int64_t kept = x.size(2) - std::abs(offset);
  if (offset > 0) return at::constant_pad_nd(x.narrow(2, offset, kept), {0, offset});
  return at::constant_pad_nd(x.narrow(2, 0, kept), {-offset, 0});
}

/// A tap of a layer that reads any sound, with its offset into the input.
struct Tap {
  std::int64_t index = 0;
  std::int64_t offset = 0;
};

std::vector<Tap> taps_of(const ViGasDescription& d, int layer, std::int64_t samples) {
  const std::int64_t centre = d.acausal ? (d.kernel_size - 1) / 2 : d.kernel_size - 1;
  std::vector<Tap> taps;
  for (std::int64_t index = 0; index < d.kernel_size; ++index) {
    const std::int64_t offset = (index - centre) * d.dilation(layer);
    if (std::abs(offset) < samples) taps.push_back({index, offset});
  }
  return taps;
}

/// The same matrix for every clip. @param weight  [outputs][inputs]
at::Tensor per_clip(const at::Tensor& weight, std::int64_t clips) {
  return weight.unsqueeze(0).expand({clips, weight.size(0), weight.size(1)});
}

}  // namespace

ViGasGraph::ViGasGraph(const ViGasWeights& weights, const at::Device& device)
    : description_(weights.description), tensors_(weights.tensors, device), stack_(description_) {}

at::Tensor ViGasGraph::image_feature(const at::Tensor& picture, GraphMode mode) {
  const at::Tensor map = resnet18(tensors_, "visual_encoder", picture, mode);
  const at::Tensor x = at::conv2d(map, parameter("conv1x1.0.weight"), parameter("conv1x1.0.bias"));
  return batch_norm(tensors_, "conv1x1.1", x, mode).relu().flatten(1);
}

at::Tensor ViGasGraph::fuse(const GraphInputs& inputs, GraphMode mode) {
  std::vector<at::Tensor> joined;
  for (const ConditioningInput& input : description_.inputs) {
    const bool is_made_here = input.name == "visual_feat" && description_.image_encoder.has_value();
    joined.push_back(is_made_here ? image_feature(inputs.picture, mode)
                                  : inputs.values.at(input.name));
    EARPOINT_CHECK(joined.back().size(1) == input.width);
  }
  const at::Tensor hidden =
      at::linear(at::cat(joined, 1), parameter("fusion.0.weight"), parameter("fusion.0.bias"));
  return at::linear(hidden.relu(), parameter("fusion.2.weight"), parameter("fusion.2.bias"));
}

at::Tensor ViGasGraph::pointwise(const std::string& name, const at::Tensor& x) {
  const at::Tensor bias = parameter(name + ".bias").unsqueeze(1);
  return at::baddbmm(bias, per_clip(parameter(name + ".weight").squeeze(2), x.size(0)), x);
}

/// Both gates of all taps as one matrix product: rows are the outputs of f, then g; columns the
/// channels of the first tap, the second, ...
at::Tensor ViGasGraph::gate(int layer, const at::Tensor& x, const at::Tensor& fused) {
  const std::string name = fmt::format("hyperconv_wavenet.layers.{}.conv.", layer);
  const auto both = [&](const char* kind, const char* part) {
    return at::cat({parameter(fmt::format("{}{}_f.{}", name, kind, part)),
                    parameter(fmt::format("{}{}_g.{}", name, kind, part))},
                   0);
  };
  const at::Tensor weight = both("w", "weight");
  std::vector<at::Tensor> columns;
  std::vector<at::Tensor> sounds;
  for (const Tap& tap : taps_of(description_, layer, x.size(2))) {
    columns.push_back(weight.select(2, tap.index));
    sounds.push_back(shifted(x, tap.offset));
  }
  const at::Tensor constant =
      at::linear(fused, both("v", "weight").squeeze(2), both("v", "bias") + both("w", "bias"));
  const at::Tensor sum = at::baddbmm(constant.unsqueeze(2),
                                     per_clip(at::cat(columns, 1), x.size(0)), at::cat(sounds, 1));
  const std::vector<at::Tensor> halves = sum.chunk(2, 1);
  return (halves[0].tanh() * halves[1].sigmoid()).sin();
}

at::Tensor ViGasGraph::synthesize(const at::Tensor& source, const at::Tensor& fused,
                                  StackKind kind) {
  return kind == StackKind::fused && source.is_cpu() ? stack_.forward(tensors_, source, fused)
                                                     : operations(source, fused);
}

at::Tensor ViGasGraph::operations(const at::Tensor& source, const at::Tensor& fused) {
  at::Tensor x = pointwise("input", source);
  at::Tensor skips;
  const int layers = description_.layers();
  for (int i = 0; i < layers; ++i) {
    const std::string name = fmt::format("hyperconv_wavenet.layers.{}.", i);
    const at::Tensor y = gate(i, x, fused);
    const at::Tensor skip = pointwise(name + "skip", y);
    skips = i == 0 ? skip : skips + skip;
    if (i + 1 < layers) x = (pointwise(name + "residual", y) + x) * 0.5;
  }
  const std::string head = fmt::format("output_net.{}.", layers - 1);
  return pointwise(head + "second", pointwise(head + "first", skips / layers).sin());
}

}  // namespace earpoint

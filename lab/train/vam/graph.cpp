#include "graph.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/conv1d.h>
#include <ATen/ops/conv_transpose1d.h>
#include <ATen/ops/glu.h>
#include <ATen/ops/layer_norm.h>
#include <ATen/ops/linear.h>
#include <ATen/ops/matmul.h>
#include <ATen/ops/silu.h>
#include <fmt/format.h>

#include <earpoint/kernels/norms.h>

namespace earpoint {
namespace {

/// Appends the pose to every token. @param tokens  [clips][tokens][width]
at::Tensor with_pose(const at::Tensor& tokens, const at::Tensor& pose) {
  return at::cat({tokens, pose.unsqueeze(1).expand({tokens.size(0), tokens.size(1), pose.size(1)})},
                 2);
}

}  // namespace

VamGraph::VamGraph(const VamWeights& weights, const at::Device& device)
    : description_(weights.description), tensors_(weights.tensors, device) {}

at::Tensor VamGraph::layer(const std::string& name, const at::Tensor& x) const {
  return at::linear(x, parameter(name + ".weight"), parameter(name + ".bias"));
}

at::Tensor VamGraph::norm(const std::string& name, const at::Tensor& x) const {
  return at::layer_norm(x, {x.size(2)}, parameter(name + ".weight"), parameter(name + ".bias"),
                        kernels::kLayerNormEpsilon);
}

at::Tensor VamGraph::attend(const std::string& name, const at::Tensor& asking,
                            const at::Tensor& asked) const {
  const std::int64_t heads = description_.heads;
  const std::int64_t part = description_.width() / heads;
  // [clips][heads][tokens][part]
  const auto split = [&](const char* which, const at::Tensor& x) {
    return layer(name + which, x).reshape({x.size(0), x.size(1), heads, part}).transpose(1, 2);
  };
  const at::Tensor scores =
      at::matmul(split(".query", asking), split(".key", asked).transpose(2, 3)) /
      std::sqrt(static_cast<double>(part));
  const at::Tensor heard = at::matmul(scores.softmax(-1), split(".value", asked));
  return layer(name + ".output", heard.transpose(1, 2).reshape(asking.sizes()));
}

at::Tensor VamGraph::convolve_tokens(const std::string& name, const at::Tensor& x) const {
  const at::Tensor gated = at::glu(layer(name + ".expand", norm(name + ".norm", x)), 2);
  const at::Tensor over_time =
      at::conv1d(gated.transpose(1, 2), parameter(name + ".depthwise.weight"),
                 parameter(name + ".depthwise.bias"), 1, description_.kernel_size / 2, 1,
                 description_.width());
  return layer(name + ".project", at::silu(over_time).transpose(1, 2));
}

at::Tensor VamGraph::block(const std::string& name, const at::Tensor& x,
                           const at::Tensor& image) const {
  const at::Tensor alone = norm(name + ".self.norm", x);
  at::Tensor y = x + attend(name + ".self", alone, alone);
  y = y + attend(name + ".cross", norm(name + ".cross.norm", y), image);
  y = y + convolve_tokens(name + ".convolution", y);
  const at::Tensor hidden =
      at::silu(layer(name + ".feed_forward.expand", norm(name + ".feed_forward.norm", y)));
  return y + layer(name + ".feed_forward.project", hidden);
}

at::Tensor VamGraph::fuse(const at::Tensor& deepest, const at::Tensor& map,
                          const at::Tensor& pose) const {
  const at::Tensor image =
      layer("image_projection", with_pose(map.flatten(2).transpose(1, 2), pose)) +
      parameter("image_position");
  at::Tensor x = layer("sound_projection", with_pose(deepest.transpose(1, 2), pose));
  for (int i = 0; i < description_.blocks; ++i) x = block(fmt::format("blocks.{}", i), x, image);
  return norm("norm", x).transpose(1, 2);
}

at::Tensor VamGraph::forward(const at::Tensor& source, const at::Tensor& picture,
                             const at::Tensor& pose, GraphMode mode) {
  const VamDescription& d = description_;
  const std::int64_t samples = source.size(2);
  const std::int64_t rest = samples % d.token_samples();
  const at::Tensor sound =
      rest == 0 ? source : at::constant_pad_nd(source, {0, d.token_samples() - rest});
  std::vector<at::Tensor> levels;
  for (int level = 0; level < d.levels(); ++level) {
    const std::string name = fmt::format("encoder.{}", level);
    levels.push_back(
        at::silu(at::conv1d(level == 0 ? sound : levels.back(), parameter(name + ".weight"),
                            parameter(name + ".bias"), d.strides[level], d.padding(level))));
  }
  at::Tensor x = fuse(levels.back(), resnet18(tensors_, "visual_encoder", picture, mode), pose);
  for (int level = d.levels() - 1; level >= 0; --level) {
    const std::string name = fmt::format("decoder.{}", level);
    x = at::silu(at::conv_transpose1d(at::cat({x, levels[level]}, 1), parameter(name + ".weight"),
                                      parameter(name + ".bias"), d.strides[level],
                                      d.padding(level)));
  }
  const at::Tensor& weight = parameter("output.weight");
  const at::Tensor out =
      at::conv1d(at::cat({x, sound}, 1), weight, parameter("output.bias"), 1, weight.size(2) / 2);
  return out.narrow(2, 0, samples);
}

}  // namespace earpoint

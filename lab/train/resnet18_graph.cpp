#include "resnet18_graph.h"

#include <cstdint>

#include <ATen/TensorOperators.h>
#include <ATen/ops/batch_norm.h>
#include <ATen/ops/conv2d.h>
#include <ATen/ops/max_pool2d.h>
#include <fmt/format.h>

#include <earpoint/kernels/norms.h>

namespace earpoint {
namespace {

constexpr double kMomentum = 0.1;

}  // namespace

at::Tensor batch_norm(const GraphTensors& tensors, const std::string& name, const at::Tensor& x,
                      GraphMode mode) {
  return at::batch_norm(x, tensors.parameter(name + ".weight"), tensors.parameter(name + ".bias"),
                        tensors.buffers.at(name + ".running_mean"),
                        tensors.buffers.at(name + ".running_var"), mode == GraphMode::training,
                        kMomentum, kernels::kBatchNormEpsilon, /*cudnn_enabled=*/true);
}

at::Tensor residual_block(const GraphTensors& tensors, const std::string& name, const at::Tensor& x,
                          bool halves, GraphMode mode) {
  const std::int64_t stride = halves ? 2 : 1;
  const auto convolved = [&](const std::string& layer, const at::Tensor& input, std::int64_t step,
                             std::int64_t padding) {
    return at::conv2d(input, tensors.parameter(name + layer + ".weight"), {}, step, padding);
  };
  at::Tensor y = batch_norm(tensors, name + ".bn1", convolved(".conv1", x, stride, 1), mode).relu();
  y = batch_norm(tensors, name + ".bn2", convolved(".conv2", y, 1, 1), mode);
  const at::Tensor identity = halves ? batch_norm(tensors, name + ".downsample.1",
                                                  convolved(".downsample.0", x, stride, 0), mode)
                                     : x;
  return (y + identity).relu();
}

at::Tensor resnet18(const GraphTensors& tensors, const std::string& prefix,
                    const at::Tensor& picture, GraphMode mode) {
  at::Tensor x = at::conv2d(picture, tensors.parameter(prefix + ".0.weight"), {}, 2, 3);
  x = batch_norm(tensors, prefix + ".1", x, mode).relu();
  x = at::max_pool2d(x, {3, 3}, {2, 2}, {1, 1});
  for (int stage = 4; stage < 8; ++stage) {
    const std::string name = fmt::format("{}.{}", prefix, stage);
    x = residual_block(tensors, name + ".0", x, stage > 4, mode);
    x = residual_block(tensors, name + ".1", x, false, mode);
  }
  return x;
}

}  // namespace earpoint

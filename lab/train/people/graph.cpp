#include "graph.h"

#include <array>

#include <ATen/TensorOperators.h>
#include <ATen/ops/conv2d.h>
#include <ATen/ops/upsample_nearest2d.h>
#include <fmt/format.h>

namespace earpoint {

using D = PeopleDescription;

PeopleGraph::PeopleGraph(const PeopleWeights& weights, const at::Device& device)
    : description(weights.description), tensors(weights.tensors, device) {}

at::Tensor PeopleGraph::run(const at::Tensor& views, GraphMode mode) const {
  const auto normed = [&](const std::string& name, const at::Tensor& x, std::int64_t stride) {
    const at::Tensor sums =
        at::conv2d(x, tensors.parameter(name + ".0.weight"), {}, stride, /*padding=*/1);
    return batch_norm(tensors, name + ".1", sums, mode).relu();
  };
  const auto plain = [&](const std::string& name, const at::Tensor& x) {
    return at::conv2d(x, tensors.parameter(name + ".weight"), tensors.parameter(name + ".bias"));
  };
  at::Tensor x = normed("stem", views, 2);
  std::array<at::Tensor, D::kStages> maps;
  for (int stage = 0; stage < D::kStages; ++stage) {
    for (int block = 0; block < D::kBlocks.at(stage); ++block) {
      x = residual_block(tensors, fmt::format("stage.{}.{}", stage, block), x, block == 0, mode);
    }
    maps.at(stage) = x;
  }
  for (int stage = D::kStages - 1; stage > 0; --stage) {
    const at::Tensor beside = plain(fmt::format("lateral.{}", stage), maps.at(stage));
    x = stage == D::kStages - 1
            ? beside
            : beside + at::upsample_nearest2d(x, {beside.size(2), beside.size(3)});
  }
  for (int layer = 0; layer < D::kHeadLayers; ++layer) {
    x = normed(fmt::format("head.{}", layer), x, 1);
  }
  return plain("output", x);
}

}  // namespace earpoint

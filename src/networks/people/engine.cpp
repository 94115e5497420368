#include <earpoint/people/engine.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/kernels/convolution_chain.h>
#include <earpoint/kernels/openmp_threads.h>

namespace earpoint {
namespace {

using kernels::After;
using kernels::ConvolutionChain;
using D = PeopleDescription;

ConvolutionChain lay_out(const PeopleWeights& weights, int height, int width, int threads) {
  const kernels::OpenMpThreads team(threads);
  const kernels::TensorByName tensor = [&](const std::string& name) -> const Tensor& {
    return weights.at(name);
  };
  ConvolutionChain chain(3, height, width, threads);
  dnnl::memory x = chain.add_convolution(
      chain.picture(), kernels::fold_batch_norm(tensor, "stem.0", "stem.1", false), {.stride = 2},
      After::relu);
  std::array<dnnl::memory, D::kStages> maps;
  for (int stage = 0; stage < D::kStages; ++stage) {
    for (int block = 0; block < D::kBlocks.at(stage); ++block) {
      x = chain.add_block(x, tensor, fmt::format("stage.{}.{}.", stage, block), block == 0);
    }
    maps.at(stage) = x;
  }
  // From the coarsest map up to that of the cells.
  dnnl::memory above;
  for (int stage = D::kStages - 1; stage > 0; --stage) {
    const dnnl::memory beside = chain.add_convolution(
        maps.at(stage), kernels::plain_convolution(tensor, fmt::format("lateral.{}", stage)),
        {.size = 1}, After::nothing);
    if (stage < D::kStages - 1) chain.add_upsampled(above, beside);
    above = beside;
  }
  for (int layer = 0; layer < D::kHeadLayers; ++layer) {
    const std::string name = fmt::format("head.{}", layer);
    above = chain.add_convolution(
        above, kernels::fold_batch_norm(tensor, name + ".0", name + ".1", false), {}, After::relu);
  }
  chain.finish(chain.add_convolution(above, kernels::plain_convolution(tensor, "output"),
                                     {.size = 1}, After::nothing));
  return chain;
}

}  // namespace

struct PeopleNetwork::State {
  PeopleWeights weights;
  int threads;
  int height = 0;
  int width = 0;
  std::optional<ConvolutionChain> chain;
  std::vector<float> map;
};

PeopleNetwork::PeopleNetwork(PeopleWeights weights, int threads)
    : state_(std::make_unique<State>(State{std::move(weights), threads, 0, 0, {}, {}})) {
  EARPOINT_CHECK(threads > 0);
}
PeopleNetwork::~PeopleNetwork() = default;
PeopleNetwork::PeopleNetwork(PeopleNetwork&&) noexcept = default;
PeopleNetwork& PeopleNetwork::operator=(PeopleNetwork&&) noexcept = default;

const PeopleDescription& PeopleNetwork::description() const { return state_->weights.description; }

std::span<const float> PeopleNetwork::run(const ImagePlanes& view) {
  State& state = *state_;
  EARPOINT_CHECK(view.channels == 3 && view.height > 0 && view.width > 0 &&
                 view.height % D::kCoarsest == 0 && view.width % D::kCoarsest == 0);
  if (view.height != state.height || view.width != state.width) {
    state.chain.emplace(lay_out(state.weights, view.height, view.width, state.threads));
    state.height = view.height;
    state.width = view.width;
    const int cells = (view.height / D::kCell) * (view.width / D::kCell);
    state.map.resize(static_cast<std::size_t>(D::kOutputs) * cells);
  }
  state.chain->run(view.values, state.map);
  return state.map;
}

}  // namespace earpoint

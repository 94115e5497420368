#include "resnet18.h"

#include "openmp_threads.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <oneapi/dnnl/dnnl.hpp>

#include <earpoint/core/error.h>

namespace earpoint::infer {
namespace {

using dnnl::memory;
using Format = memory::format_tag;

constexpr double kBatchNormEpsilon = 1e-5;

memory::desc floats(const memory::dims& shape, Format format) {
  return {shape, memory::data_type::f32, format};
}

/// Kernel, stride and padding of a square window.
struct Window {
  int size = 3;
  int stride = 1;
  [[nodiscard]] int padding() const { return size / 2; }
};

enum class After { nothing, relu };

}  // namespace

FoldedConvolution fold_batch_norm(const TensorByName& tensor, const std::string& convolution,
                                  const std::string& norm, bool has_bias) {
  const Tensor& weight = tensor(convolution + ".weight");
  const auto values = weight.as<float>();
  const auto gain = tensor(norm + ".weight").as<float>();
  const auto offset = tensor(norm + ".bias").as<float>();
  const auto mean = tensor(norm + ".running_mean").as<float>();
  const auto variance = tensor(norm + ".running_var").as<float>();
  FoldedConvolution folded;
  const std::size_t size = values.size() / gain.size();
  for (std::size_t out = 0; out < gain.size(); ++out) {
    const double scale = gain[out] / std::sqrt(variance[out] + kBatchNormEpsilon);
    for (std::size_t i = 0; i < size; ++i) {
      folded.weight.push_back(static_cast<float>(scale * values[out * size + i]));
    }
    const double bias = has_bias ? tensor(convolution + ".bias").as<float>()[out] : 0.0;
    folded.bias.push_back(static_cast<float>(offset[out] + scale * (bias - mean[out])));
  }
  return folded;
}

struct ResNet18::State {
  explicit State(int thread_count) : threads(thread_count) {}

  [[nodiscard]] memory make(const memory::desc& desc) const { return {desc, engine}; }
  memory reordered(memory from, const memory::desc& to);
  memory add_convolution(const memory& from, const FoldedConvolution& folded, Window window,
                         After after, const memory* add_to = nullptr);
  memory add_max_pool(const memory& from);
  memory add_block(const memory& from, const TensorByName& tensor, const std::string& name,
                   bool halve);
  void add_step(dnnl::primitive primitive, std::unordered_map<int, memory> arguments);

  int threads;
  dnnl::engine engine{dnnl::engine::kind::cpu, 0};
  dnnl::stream stream{engine};
  std::vector<std::pair<dnnl::primitive, std::unordered_map<int, memory>>> steps;
  memory picture;
  memory map;  ///< in nchw
};

void ResNet18::State::add_step(dnnl::primitive primitive,
                               std::unordered_map<int, memory> arguments) {
  steps.emplace_back(std::move(primitive), std::move(arguments));
}

/// A copy in another layout, made now.
memory ResNet18::State::reordered(memory from, const memory::desc& to) {
  memory copy = make(to);
  dnnl::reorder(from, copy).execute(stream, from, copy);
  stream.wait();
  return copy;
}

/// Adds convolution + bias, then optionally + what `add_to` holds (and replaces it), then ReLU.
memory ResNet18::State::add_convolution(const memory& from, const FoldedConvolution& folded,
                                        Window window, After after, const memory* add_to) {
  const memory::dims in = from.get_desc().dims();
  const auto out_channels = static_cast<memory::dim>(folded.bias.size());
  const memory::dim padding = window.padding();
  const auto out_size = [&](memory::dim size) {
    return (size + 2 * padding - window.size) / window.stride + 1;
  };
  const memory::dims out = {1, out_channels, out_size(in[2]), out_size(in[3])};
  const memory::dims kernel = {out_channels, in[1], window.size, window.size};

  dnnl::post_ops post_ops;
  if (add_to != nullptr) post_ops.append_sum(1.0F);
  if (after == After::relu) {
    post_ops.append_eltwise(1.0F, dnnl::algorithm::eltwise_relu, 0.0F, 0.0F);
  }
  dnnl::primitive_attr attributes;
  attributes.set_post_ops(post_ops);
  const memory::desc to = add_to != nullptr ? add_to->get_desc() : floats(out, Format::any);
  const dnnl::convolution_forward::desc operation(
      dnnl::prop_kind::forward_inference, dnnl::algorithm::convolution_direct, from.get_desc(),
      floats(kernel, Format::any), floats({out_channels}, Format::x), to,
      {window.stride, window.stride}, {padding, padding}, {padding, padding});
  const dnnl::convolution_forward::primitive_desc chosen(operation, attributes, engine);

  // oneDNN asks for memory that it may change; it only reads this.
  const auto constant = [&](const std::vector<float>& values, const memory::desc& desc) {
    return memory(desc, engine, const_cast<float*>(values.data()));
  };
  const memory weight =
      reordered(constant(folded.weight, floats(kernel, Format::oihw)), chosen.weights_desc());
  const memory bias = reordered(constant(folded.bias, chosen.bias_desc()), chosen.bias_desc());
  memory result = add_to != nullptr ? *add_to : make(chosen.dst_desc());
  add_step(dnnl::convolution_forward(chosen), {{DNNL_ARG_SRC, from},
                                               {DNNL_ARG_WEIGHTS, weight},
                                               {DNNL_ARG_BIAS, bias},
                                               {DNNL_ARG_DST, result}});
  return result;
}

/// 3x3, stride 2, padding 1; padding never wins.
memory ResNet18::State::add_max_pool(const memory& from) {
  const memory::dims in = from.get_desc().dims();
  const memory::dims out = {1, in[1], (in[2] + 1) / 2, (in[3] + 1) / 2};
  const dnnl::pooling_forward::desc operation(
      dnnl::prop_kind::forward_inference, dnnl::algorithm::pooling_max, from.get_desc(),
      floats(out, Format::any), {2, 2}, {3, 3}, {1, 1}, {1, 1});
  const dnnl::pooling_forward::primitive_desc chosen(operation, engine);
  memory result = make(chosen.dst_desc());
  add_step(dnnl::pooling_forward(chosen), {{DNNL_ARG_SRC, from}, {DNNL_ARG_DST, result}});
  return result;
}

/// Basic block: two 3x3 convolutions beside an identity, or a 1x1 convolution where it halves.
memory ResNet18::State::add_block(const memory& from, const TensorByName& tensor,
                                  const std::string& name, bool halve) {
  const int stride = halve ? 2 : 1;
  const auto fold = [&](const char* convolution, const char* norm) {
    return fold_batch_norm(tensor, name + convolution, name + norm, false);
  };
  const memory first = add_convolution(from, fold("conv1", "bn1"), {.stride = stride}, After::relu);
  const memory beside = halve ? add_convolution(from, fold("downsample.0", "downsample.1"),
                                                {.size = 1, .stride = stride}, After::nothing)
                              : from;
  return add_convolution(first, fold("conv2", "bn2"), {}, After::relu, &beside);
}

ResNet18::ResNet18(const TensorByName& tensor, const std::string& prefix, int channels, int height,
                   int width, int threads)
    : state_(std::make_unique<State>(threads)) {
  const OpenMpThreads team(threads);
  State& state = *state_;
  state.picture = state.make(floats({1, channels, height, width}, Format::nchw));
  memory x = state.add_convolution(state.picture,
                                   fold_batch_norm(tensor, prefix + ".0", prefix + ".1", false),
                                   {.size = 7, .stride = 2}, After::relu);
  x = state.add_max_pool(x);
  for (int stage = 4; stage <= 7; ++stage) {
    for (int block = 0; block < 2; ++block) {
      x = state.add_block(x, tensor, fmt::format("{}.{}.{}.", prefix, stage, block),
                          stage > 4 && block == 0);
    }
  }
  state.map = state.make(floats(x.get_desc().dims(), Format::nchw));
  state.add_step(dnnl::reorder(x, state.map), {{DNNL_ARG_FROM, x}, {DNNL_ARG_TO, state.map}});
}

ResNet18::~ResNet18() = default;
ResNet18::ResNet18(ResNet18&&) noexcept = default;
ResNet18& ResNet18::operator=(ResNet18&&) noexcept = default;

int ResNet18::map_height() const { return static_cast<int>(state_->map.get_desc().dims()[2]); }
int ResNet18::map_width() const { return static_cast<int>(state_->map.get_desc().dims()[3]); }

int ResNet18::channels() const { return static_cast<int>(state_->map.get_desc().dims()[1]); }

void ResNet18::run(std::span<const float> picture, std::span<float> map) {
  State& state = *state_;
  EARPOINT_CHECK(picture.size_bytes() == state.picture.get_desc().get_size());
  EARPOINT_CHECK(map.size_bytes() == state.map.get_desc().get_size());
  const OpenMpThreads team(state.threads);
  std::copy(picture.begin(), picture.end(), static_cast<float*>(state.picture.get_data_handle()));
  for (const auto& [primitive, arguments] : state.steps) primitive.execute(state.stream, arguments);
  state.stream.wait();
  const auto* values = static_cast<const float*>(state.map.get_data_handle());
  std::copy(values, values + map.size(), map.begin());
}

}  // namespace earpoint::infer

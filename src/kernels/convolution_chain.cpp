#include <earpoint/kernels/convolution_chain.h>

#include <algorithm>

#include <earpoint/error.h>
#include <earpoint/kernels/openmp_threads.h>

namespace earpoint::kernels {
namespace {

using dnnl::memory;
using Format = memory::format_tag;

memory::desc floats(const memory::dims& shape, Format format) {
  return {shape, memory::data_type::f32, format};
}

}  // namespace

ConvolutionChain::ConvolutionChain(int channels, int height, int width, int threads)
    : threads_(threads), picture_(make(floats({1, channels, height, width}, Format::nchw))) {}

void ConvolutionChain::add_step(dnnl::primitive primitive,
                                std::unordered_map<int, memory> arguments) {
  steps_.emplace_back(std::move(primitive), std::move(arguments));
}

memory ConvolutionChain::reordered(memory from, const memory::desc& to) {
  memory copy = make(to);
  dnnl::reorder(from, copy).execute(stream_, from, copy);
  stream_.wait();
  return copy;
}

memory ConvolutionChain::add_convolution(const memory& from, const FoldedConvolution& folded,
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
  const dnnl::convolution_forward::primitive_desc chosen(operation, attributes, engine_);

  // oneDNN asks for memory that it may change; it only reads this.
  const auto constant = [&](const std::vector<float>& values, const memory::desc& desc) {
    return memory(desc, engine_, const_cast<float*>(values.data()));
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

memory ConvolutionChain::add_max_pool(const memory& from) {
  const memory::dims in = from.get_desc().dims();
  const memory::dims out = {1, in[1], (in[2] + 1) / 2, (in[3] + 1) / 2};
  const dnnl::pooling_forward::desc operation(
      dnnl::prop_kind::forward_inference, dnnl::algorithm::pooling_max, from.get_desc(),
      floats(out, Format::any), {2, 2}, {3, 3}, {1, 1}, {1, 1});
  const dnnl::pooling_forward::primitive_desc chosen(operation, engine_);
  memory result = make(chosen.dst_desc());
  add_step(dnnl::pooling_forward(chosen), {{DNNL_ARG_SRC, from}, {DNNL_ARG_DST, result}});
  return result;
}

memory ConvolutionChain::add_block(const memory& from, const TensorByName& tensor,
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

void ConvolutionChain::add_upsampled(const memory& from, const memory& to) {
  dnnl::post_ops post_ops;
  post_ops.append_sum(1.0F);
  dnnl::primitive_attr attributes;
  attributes.set_post_ops(post_ops);
  const dnnl::resampling_forward::desc operation(dnnl::prop_kind::forward_inference,
                                                 dnnl::algorithm::resampling_nearest,
                                                 from.get_desc(), to.get_desc());
  const dnnl::resampling_forward::primitive_desc chosen(operation, attributes, engine_);
  add_step(dnnl::resampling_forward(chosen), {{DNNL_ARG_SRC, from}, {DNNL_ARG_DST, to}});
}

void ConvolutionChain::finish(const memory& last) {
  map_ = make(floats(last.get_desc().dims(), Format::nchw));
  add_step(dnnl::reorder(last, map_), {{DNNL_ARG_FROM, last}, {DNNL_ARG_TO, map_}});
}

void ConvolutionChain::run(std::span<const float> picture, std::span<float> map) {
  EARPOINT_CHECK(picture.size_bytes() == picture_.get_desc().get_size());
  EARPOINT_CHECK(map.size_bytes() == map_.get_desc().get_size());
  const OpenMpThreads team(threads_);
  std::copy(picture.begin(), picture.end(), static_cast<float*>(picture_.get_data_handle()));
  for (const auto& [primitive, arguments] : steps_) primitive.execute(stream_, arguments);
  stream_.wait();
  const auto* values = static_cast<const float*>(map_.get_data_handle());
  std::copy(values, values + map.size(), map.begin());
}

}  // namespace earpoint::kernels

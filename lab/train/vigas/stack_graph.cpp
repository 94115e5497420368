#include "stack_graph.h"

#include "fused_stack.h"
#include "stack_kernels.h"

#include <cstdint>
#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <ATen/Parallel.h>
#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/empty_like.h>
#include <ATen/ops/linear.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>
#include <fmt/format.h>
#include <torch/csrc/autograd/custom_function.h>

#include <earpoint/error.h>

#if AT_PARALLEL_OPENMP && !defined(_OPENMP)
#error "at::parallel_for() is a plain loop where OpenMP is not switched on"
#endif

namespace earpoint {
namespace {

using training::FusedStack;
using training::StackShape;
using training::StackSizes;

StackShape shape_of(const ViGasDescription& d) {
  StackShape shape;
  shape.audio_channels = d.audio_channels;
  shape.channels =
      (d.channels + training::kChannelStep - 1) / training::kChannelStep * training::kChannelStep;
  shape.taps = d.kernel_size;
  shape.centre = d.acausal ? (d.kernel_size - 1) / 2 : d.kernel_size - 1;
  for (int layer = 0; layer < d.layers(); ++layer) shape.dilations.push_back(d.dilation(layer));
  return shape;
}

void run_loop(std::ptrdiff_t count,
              const std::function<void(std::ptrdiff_t, std::ptrdiff_t, int)>& work) {
  at::parallel_for(0, count, 1, [&](std::int64_t begin, std::int64_t end) {
    work(begin, end, at::get_thread_num());
  });
}

/// Zeros behind the last two axes.
at::Tensor padded(const at::Tensor& matrices, std::int64_t rows, std::int64_t columns) {
  return at::constant_pad_nd(matrices,
                             {0, columns - matrices.size(-1), 0, rows - matrices.size(-2)});
}

/// Packs all parameters of the stack in the order of StackSizes.
class Packing {
 public:
  Packing(const ViGasDescription& description, const StackShape& shape, const GraphTensors& tensors)
      : description_(description), shape_(shape), tensors_(tensors) {}

  [[nodiscard]] at::Tensor all(const at::Tensor& fused) const {
    const int layers = description_.layers();
    const std::int64_t c = shape_.channels;
    const std::string head = fmt::format("output_net.{}.", layers - 1);
    const at::Tensor skip_bias = of_layers("skip.bias", layers).mean(0);
    const std::vector<at::Tensor> parts = {
        matrix("input", training::kChannelStep, c),
        bias(tensors_.parameter("input.bias"), c),
        at::cat({gates("f"), gates("g")}, 3),
        residual(layers - 1),
        residual_bias(layers - 1),
        matrices("skip.weight", layers) * (1.0 / layers),
        bias(skip_bias, c),
        matrix(head + "first", c, c),
        bias(tensors_.parameter(head + "first.bias"), c),
        matrix(head + "second", c, training::kChannelStep),
        bias(tensors_.parameter(head + "second.bias"), training::kChannelStep),
        constants(fused)};
    std::vector<at::Tensor> flat;
    for (const at::Tensor& part : parts) flat.push_back(part.reshape({-1}));
    return at::cat(flat);
  }

 private:
  /// Of the first `count` layers, one behind the other; at least one.
  [[nodiscard]] at::Tensor of_layers(const std::string& name, int count) const {
    std::vector<at::Tensor> tensors;
    for (int layer = 0; layer < count; ++layer) {
      tensors.push_back(
          tensors_.parameter(fmt::format("hyperconv_wavenet.layers.{}.{}", layer, name)));
    }
    return at::stack(tensors);
  }

  [[nodiscard]] at::Tensor residual(int count) const {
    return count == 0 ? nothing() : matrices("residual.weight", count) * 0.5;
  }
  [[nodiscard]] at::Tensor residual_bias(int count) const {
    return count == 0 ? nothing()
                      : padded(of_layers("residual.bias", count), count, shape_.channels) * 0.5;
  }
  /// A network of one layer has no residual.
  static at::Tensor nothing() { return at::zeros({0}); }

  /// 1x1 convolutions, [layers][in][out].
  [[nodiscard]] at::Tensor matrices(const std::string& name, int count) const {
    return padded(of_layers(name, count).squeeze(3).transpose(1, 2), shape_.channels,
                  shape_.channels);
  }

  /// One gate's dilated convolutions, [layers][taps][in][out].
  [[nodiscard]] at::Tensor gates(const std::string& gate) const {
    const at::Tensor weights = of_layers("conv.w_" + gate + ".weight", description_.layers());
    return padded(weights.permute({0, 3, 2, 1}), shape_.channels, shape_.channels);
  }

  [[nodiscard]] at::Tensor matrix(const std::string& name, std::int64_t inputs,
                                  std::int64_t outputs) const {
    return padded(tensors_.parameter(name + ".weight").squeeze(2).transpose(0, 1), inputs, outputs);
  }

  static at::Tensor bias(const at::Tensor& values, std::int64_t width) {
    return at::constant_pad_nd(values, {0, width - values.size(0)});
  }

  /// What is added to one gate, [clips][layers][channels].
  [[nodiscard]] at::Tensor constants_of(const std::string& gate, const at::Tensor& fused) const {
    const int layers = description_.layers();
    const at::Tensor weight = of_layers("conv.v_" + gate + ".weight", layers).flatten(0, 1);
    const at::Tensor biases = of_layers("conv.v_" + gate + ".bias", layers) +
                              of_layers("conv.w_" + gate + ".bias", layers);
    const at::Tensor sum = at::linear(fused, weight.squeeze(2), biases.flatten());
    return padded(sum.reshape({fused.size(0), layers, description_.channels}), layers,
                  shape_.channels);
  }

  [[nodiscard]] at::Tensor constants(const at::Tensor& fused) const {
    return at::cat({constants_of("f", fused), constants_of("g", fused)}, 2);
  }

  const ViGasDescription& description_;
  const StackShape& shape_;
  const GraphTensors& tensors_;
};

training::StackParameters<const float> parameters_in(const StackSizes& sizes,
                                                     const at::Tensor& all) {
  const training::StackParameters<float> p = training::consecutive(sizes, all.data_ptr<float>());
  return {p.input,     p.input_bias, p.gate,       p.residual, p.residual_bias, p.skip,
          p.skip_bias, p.first,      p.first_bias, p.second,   p.second_bias,   p.constants};
}

/// The matrices in `all`, transposed.
struct Transposed {
  Transposed(const StackShape& shape, const StackSizes& sizes, const at::Tensor& all) {
    std::int64_t begin = 0;
    const auto turned = [&](std::size_t index, at::IntArrayRef matrices) {
      begin = std::accumulate(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(index),
                              std::int64_t{0});
      return all.narrow(0, begin, sizes[index]).view(matrices).transpose(-1, -2).contiguous();
    };
    const std::int64_t c = shape.channels;
    gate = turned(2, {-1, c, 2 * c});
    if (shape.layers() > 1) residual = turned(3, {-1, c, c});
    skip = turned(5, {-1, c, c});
    first = turned(7, {c, c});
    second = turned(9, {c, training::kChannelStep});
  }

  [[nodiscard]] training::TransposedParameters pointers() const {
    return {gate.data_ptr<float>(), residual.defined() ? residual.data_ptr<float>() : nullptr,
            skip.data_ptr<float>(), first.data_ptr<float>(), second.data_ptr<float>()};
  }

  at::Tensor gate, residual, skip, first, second;
};

/// The stack and its memory, shared by the graph and its outputs.
struct StackMemory : torch::CustomClassHolder {
  explicit StackMemory(const ViGasDescription& description) : shape(shape_of(description)) {}

  /// For as many threads as LibTorch has now.
  FusedStack& stack() {
    if (threads != at::get_num_threads()) {
      threads = at::get_num_threads();
      fused = std::make_unique<FusedStack>(shape, threads, run_loop);
    }
    return *fused;
  }

  StackShape shape;
  int threads = 0;
  std::unique_ptr<FusedStack> fused;
  std::int64_t passes = 0;  ///< forward, so far
};

/// The node of the graph: from the source and all parameters to the output.
struct StackFunction : torch::autograd::Function<StackFunction> {
  static at::Tensor forward(torch::autograd::AutogradContext* context,
                            const c10::intrusive_ptr<StackMemory>& memory, bool keep,
                            const at::Tensor& source, const at::Tensor& all) {
    const std::int64_t clips = source.size(0);
    const StackSizes sizes = training::stack_sizes(memory->shape, clips);
    at::Tensor output = at::empty_like(source);
    memory->stack().forward(parameters_in(sizes, all), source.data_ptr<float>(), clips,
                            source.size(2), keep, output.data_ptr<float>());
    ++memory->passes;
    context->save_for_backward({source, all});
    context->saved_data["passes"] = memory->passes;
    context->saved_data["memory"] = at::IValue::make_capsule(memory);
    return output;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 const torch::autograd::variable_list& by_output) {
    const auto memory =
        c10::static_intrusive_pointer_cast<StackMemory>(context->saved_data["memory"].toCapsule());
    // The memory must still be that of this node's forward pass.
    EARPOINT_CHECK(context->saved_data["passes"].toInt() == memory->passes);
    const auto saved = context->get_saved_variables();
    const at::Tensor& source = saved[0];
    const at::Tensor& all = saved[1];
    const StackSizes sizes = training::stack_sizes(memory->shape, source.size(0));
    const Transposed transposed(memory->shape, sizes, all);
    const at::Tensor gradients = at::zeros({memory->threads, all.size(0)}, all.options());
    const at::Tensor by_sound = by_output[0].contiguous();
    memory->stack().backward(parameters_in(sizes, all), transposed.pointers(),
                             source.data_ptr<float>(), by_sound.data_ptr<float>(),
                             gradients.data_ptr<float>());
    return {{}, {}, {}, gradients.sum(0)};
  }
};

}  // namespace

struct StackGraph::State {
  ViGasDescription description;
  c10::intrusive_ptr<StackMemory> memory;
};

StackGraph::StackGraph(const ViGasDescription& description)
    : state_(std::make_unique<State>(
          State{description, c10::make_intrusive<StackMemory>(description)})) {}
StackGraph::~StackGraph() = default;
StackGraph::StackGraph(StackGraph&&) noexcept = default;
StackGraph& StackGraph::operator=(StackGraph&&) noexcept = default;

at::Tensor StackGraph::forward(const GraphTensors& tensors, const at::Tensor& source,
                               const at::Tensor& fused) {
  const Packing packing(state_->description, state_->memory->shape, tensors);
  return StackFunction::apply(state_->memory, at::GradMode::is_enabled(), source.contiguous(),
                              packing.all(fused));
}

}  // namespace earpoint

#include "trunk_pass.h"

#include "trunk_kernels.h"
#include "vigas/stack_kernels.h"

#include <algorithm>

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>
#include <ATen/ops/zeros_like.h>
#include <torch/csrc/autograd/custom_function.h>

#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>

namespace earpoint {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;
using training::Outer;
using training::Product;
using training::Rows;

constexpr std::int64_t kTaps = gtf::kTrunkTaps;

std::int64_t whole_steps(std::int64_t count) {
  return (count + training::kChannelStep - 1) / training::kChannelStep * training::kChannelStep;
}

/// Sizes of one call. All channels and features are whole steps.
struct Extent {
  std::int64_t clips, features, channels, row, layers;
  std::vector<std::int64_t> dilations;

  /// Zeros before the first frame, as many as the farthest tap reads.
  [[nodiscard]] std::int64_t before() const {
    return whole_steps((kTaps - 1) * *std::ranges::max_element(dilations));
  }
  [[nodiscard]] std::int64_t long_row() const { return before() + row; }
  [[nodiscard]] std::int64_t offset(std::int64_t layer, std::int64_t tap) const {
    return (kTaps - 1 - tap) * dilations[layer];
  }
  [[nodiscard]] Rows rows() const { return {channels, row}; }
};

Extent extent_of(const at::Tensor& features, const at::Tensor& weights,
                 std::vector<std::int64_t> dilations) {
  return {features.size(0), features.size(1), weights.size(1),
          features.size(2), weights.size(0),  std::move(dilations)};
}

/// The values that a clip's forward pass keeps.
struct Kept {
  at::Tensor inputs;  ///< [clips][channels][row]: of the first silu
  at::Tensor states;  ///< [clips][layers][channels][before + row]: what each layer reads
  at::Tensor sums;    ///< [clips][layers][channels][row]: of the convolutions
};

class TrunkPass : public torch::autograd::Function<TrunkPass> {
 public:
  /// @param weights  [layers][channels][3 * channels] @param biases  [layers][channels]
  /// @param films    [clips][layers][2][channels]
  static at::Tensor forward(AutogradContext* context, const at::Tensor& features,
                            const at::Tensor& input_weight, const at::Tensor& input_bias,
                            const at::Tensor& weights, const at::Tensor& biases,
                            const at::Tensor& films, const std::vector<std::int64_t>& dilations) {
    const Extent e = extent_of(features, weights, dilations);
    const Kept kept{at::empty({e.clips, e.channels, e.row}),
                    at::zeros({e.clips, e.layers, e.channels, e.long_row()}),
                    at::empty({e.clips, e.layers, e.channels, e.row})};
    at::Tensor output = at::empty({e.clips, e.channels, e.row});
    at::Tensor last = at::empty({e.channels, e.long_row()});
    for (std::int64_t clip = 0; clip < e.clips; ++clip) {
      float* input = kept.inputs.data_ptr<float>() + clip * kept.inputs.stride(0);
      fill(e, input_bias.data_ptr<float>(), input);
      const Product dense{input_weight.data_ptr<float>(), e.features, e.features,
                          features.data_ptr<float>() + clip * features.stride(0), e.row};
      training::add_products({&dense, 1}, input, e.row, e.channels, e.row);
      float* state = kept.states.data_ptr<float>() + clip * kept.states.stride(0);
      training::silu(e.rows(), input, state + e.before(), e.long_row());
      for (std::int64_t layer = 0; layer < e.layers; ++layer) {
        float* y =
            kept.sums.data_ptr<float>() + clip * kept.sums.stride(0) + layer * kept.sums.stride(1);
        fill(e, biases.data_ptr<float>() + layer * e.channels, y);
        std::vector<Product> taps;
        for (std::int64_t tap = 0; tap < kTaps; ++tap) {
          taps.push_back({weights.data_ptr<float>() + layer * weights.stride(0) + tap * e.channels,
                          kTaps * e.channels, e.channels, state + e.before() - e.offset(layer, tap),
                          e.long_row()});
        }
        training::add_products(taps, y, e.row, e.channels, e.row);
        const float* film =
            films.data_ptr<float>() + clip * films.stride(0) + layer * films.stride(1);
        float* next = layer + 1 < e.layers ? state + kept.states.stride(1) : last.data_ptr<float>();
        training::modulate(e.rows(), y, film, film + e.channels, state + e.before(),
                           next + e.before(), e.long_row());
        state = next;
      }
      float* to = output.data_ptr<float>() + clip * output.stride(0);
      for (std::int64_t c = 0; c < e.channels; ++c) {
        std::copy_n(state + c * e.long_row() + e.before(), e.row, to + c * e.row);
      }
    }
    context->saved_data["dilations"] = dilations;
    context->save_for_backward(
        {features, input_weight, weights, films, kept.inputs, kept.states, kept.sums});
    return output;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor& features = saved[0];
    const at::Tensor& input_weight = saved[1];
    const at::Tensor& weights = saved[2];
    const at::Tensor& films = saved[3];
    const Extent e = extent_of(features, weights, context->saved_data["dilations"].toIntVector());
    const at::Tensor by_output = gradients[0].contiguous();
    at::Tensor by_input_weight = at::zeros_like(input_weight);
    at::Tensor by_input_bias = at::zeros({e.channels});
    at::Tensor by_weights = at::zeros_like(weights);
    at::Tensor by_biases = at::zeros({e.layers, e.channels});
    at::Tensor by_films = at::empty_like(films);
    at::Tensor by_state = at::empty({e.channels, e.row});
    // Zeros after the last frame, for taps that reach past it.
    at::Tensor by_sums = at::zeros({e.channels, e.long_row()});
    at::Tensor across = at::empty({e.long_row(), std::max(e.channels, e.features)});
    float* slope = by_state.data_ptr<float>();
    float* by_y = by_sums.data_ptr<float>();
    float* turned = across.data_ptr<float>();
    for (std::int64_t clip = 0; clip < e.clips; ++clip) {
      std::copy_n(by_output.data_ptr<float>() + clip * by_output.stride(0), e.channels * e.row,
                  slope);
      for (std::int64_t layer = e.layers - 1; layer >= 0; --layer) {
        const auto of_layer = [&](const at::Tensor& tensor) {
          return tensor.data_ptr<float>() + clip * tensor.stride(0) + layer * tensor.stride(1);
        };
        const float* film = of_layer(films);
        float* by_film = of_layer(by_films);
        training::modulate_back(e.rows(), of_layer(saved[6]), film, film + e.channels, slope, by_y,
                                e.long_row(), by_film, by_film + e.channels);
        training::add_row_sums(e.rows(), by_y, e.long_row(),
                               by_biases.data_ptr<float>() + layer * e.channels);
        training::transpose(of_layer(saved[5]), e.long_row(), e.channels, e.long_row(), turned,
                            e.channels);
        for (std::int64_t tap = 0; tap < kTaps; ++tap) {
          const std::int64_t at = layer * weights.stride(0) + tap * e.channels;
          const std::int64_t offset = e.offset(layer, tap);
          const Product by_tap{by_y, e.long_row(), e.row,
                               turned + (e.before() - offset) * e.channels, e.channels};
          training::add_products({&by_tap, 1}, by_weights.data_ptr<float>() + at,
                                 kTaps * e.channels, e.channels, e.channels);
          training::add_outer_products({weights.data_ptr<float>() + at, kTaps * e.channels,
                                        by_y + offset, e.long_row(), e.channels, e.channels, e.row,
                                        slope});
        }
      }
      training::silu_back(e.rows(), saved[4].data_ptr<float>() + clip * saved[4].stride(0), slope);
      training::add_row_sums(e.rows(), slope, e.row, by_input_bias.data_ptr<float>());
      training::transpose(features.data_ptr<float>() + clip * features.stride(0), e.row, e.features,
                          e.row, turned, e.features);
      const Product by_dense{slope, e.row, e.row, turned, e.features};
      training::add_products({&by_dense, 1}, by_input_weight.data_ptr<float>(), e.features,
                             e.channels, e.features);
    }
    return {{}, by_input_weight, by_input_bias, by_weights, by_biases, by_films, {}};
  }

 private:
  /// Every row of a channel becomes its bias.
  static void fill(const Extent& e, const float* bias, float* to) {
    for (std::int64_t c = 0; c < e.channels; ++c) std::fill_n(to + c * e.row, e.row, bias[c]);
  }
};

/// Pads the last axis with zeros to whole steps.
at::Tensor filled_up(const at::Tensor& x) {
  const std::int64_t missing = whole_steps(x.size(-1)) - x.size(-1);
  return missing == 0 ? x : at::constant_pad_nd(x, {0, missing});
}
/// The same, of the last two axes.
at::Tensor both_filled_up(const at::Tensor& x) {
  return filled_up(filled_up(x).transpose(-1, -2)).transpose(-1, -2).contiguous();
}

}  // namespace

at::Tensor trunk_pass(const TrunkTensors& tensors, const at::Tensor& features, std::int64_t frames,
                      std::int64_t ahead) {
  EARPOINT_CHECK(frames > ahead);
  const std::int64_t channels = tensors.input_weight.size(0);
  std::vector<at::Tensor> weights;
  std::vector<at::Tensor> films;
  for (const at::Tensor& weight : tensors.weights) {
    // [3][channels][channels] to [channels][3 * channels], each tap filled up.
    weights.push_back(both_filled_up(weight.permute({2, 0, 1})).transpose(0, 1).flatten(1));
  }
  for (const at::Tensor& film : tensors.films) {
    films.push_back(filled_up(film.reshape({film.size(0), 2, channels})));
  }
  std::vector<at::Tensor> biases;
  for (const at::Tensor& bias : tensors.biases) biases.push_back(filled_up(bias));

  at::Tensor seen = at::zeros({features.size(0), whole_steps(features.size(1)), features.size(2)});
  seen.narrow(1, 0, features.size(1))
      .narrow(2, 0, frames - ahead)
      .copy_(features.narrow(2, ahead, frames - ahead));
  return TrunkPass::apply(seen, both_filled_up(tensors.input_weight), filled_up(tensors.input_bias),
                          at::stack(weights), at::stack(biases), at::stack(films, 1),
                          tensors.dilations)
      .narrow(1, 0, channels);
}

}  // namespace earpoint

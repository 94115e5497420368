#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/kernels/stack_plan.h>

namespace earpoint::kernels {

/// Weights of one layer, as in the released state dict: row-major, [out][in][tap].
struct GatedLayerWeights {
  DilatedConvolution convolution;
  std::span<const float> filter_weight, filter_bias;                            ///< `conv.w_f`
  std::span<const float> gate_weight, gate_bias;                                ///< `conv.w_g`
  std::span<const float> filter_conditioning_weight, filter_conditioning_bias;  ///< `conv.v_f`
  std::span<const float> gate_conditioning_weight, gate_conditioning_bias;      ///< `conv.v_g`
  std::span<const float> residual_weight, residual_bias;  ///< empty in the last layer
  std::span<const float> skip_weight, skip_bias;
};

/// Weights of the audio core.
struct GatedStackWeights {
  std::ptrdiff_t audio_channels = 0;
  std::ptrdiff_t channels = 0;
  std::ptrdiff_t conditioning_width = 0;
  std::span<const float> input_weight, input_bias;
  std::vector<GatedLayerWeights> layers;
  std::span<const float> first_weight, first_bias;    ///< of the last output head
  std::span<const float> second_weight, second_bias;  ///< of the last output head
};

}  // namespace earpoint::kernels

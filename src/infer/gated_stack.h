#pragma once

#include "stack_plan.h"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace earpoint::infer {

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
  int audio_channels = 0;
  int channels = 0;
  int conditioning_width = 0;
  std::span<const float> input_weight, input_bias;
  std::vector<GatedLayerWeights> layers;
  std::span<const float> first_weight, first_bias;    ///< of the last output head
  std::span<const float> second_weight, second_bias;  ///< of the last output head
};

/// The audio core of ViGAS: 1x1 convolution, gated dilated stack, mean of the skips, output head.
/// Source: oracle notes on the released code, section 2.3.
class GatedStack {
 public:
  /// Packs the weights; they are not needed afterwards.
  /// @param threads  > 0; has no influence on the result
  GatedStack(const GatedStackWeights& weights, int threads);
  ~GatedStack();
  GatedStack(GatedStack&&) noexcept;
  GatedStack& operator=(GatedStack&&) noexcept;

  /// Makes room and plans for waveforms of that length. run() does it by itself when the length
  /// changes, and allocates nothing otherwise.
  /// @param samples  > 0
  void reserve(std::ptrdiff_t samples);

  /// @param source        planar, [audio_channels][samples], samples > 0
  /// @param conditioning  [conditioning_width]
  /// @param output        planar, [audio_channels][samples]
  void run(std::span<const float> source, std::span<const float> conditioning,
           std::span<float> output);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint::infer

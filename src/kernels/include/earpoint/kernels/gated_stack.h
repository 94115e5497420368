#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include <earpoint/kernels/stack_weights.h>

namespace earpoint::kernels {

/// The audio core of ViGAS: 1x1 convolution, gated dilated stack, mean of the skips, output head.
/// Source: docs/released-code.md, gated stack.
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

}  // namespace earpoint::kernels

#pragma once

#include <array>
#include <cstddef>
#include <iterator>
#include <vector>

namespace earpoint::training {

/// What the gated stack looks like. `channels` is a multiple of kChannelStep.
struct StackShape {
  std::ptrdiff_t audio_channels = 0;  ///< at most kChannelStep
  std::ptrdiff_t channels = 0;
  std::ptrdiff_t taps = 0;
  std::ptrdiff_t centre = 0;              ///< the tap that reads the output's own sample
  std::vector<std::ptrdiff_t> dilations;  ///< by layer

  [[nodiscard]] std::ptrdiff_t layers() const { return std::ssize(dilations); }
};

/// Weights of the stack, or their gradients: matrices are [in][out], what turns one row of channels
/// into another. Audio channels are padded to kChannelStep.
template <class Float>
struct StackParameters {
  Float* input = nullptr;          ///< [audio][channels]
  Float* input_bias = nullptr;     ///< [channels]
  Float* gate = nullptr;           ///< [layers][taps][channels][filters, then gates]
  Float* residual = nullptr;       ///< [layers - 1][channels][channels]; halves included
  Float* residual_bias = nullptr;  ///< [layers - 1][channels]; halves included
  Float* skip = nullptr;           ///< [layers][channels][channels]; a layer's share included
  Float* skip_bias = nullptr;      ///< [channels], of all layers together
  Float* first = nullptr;          ///< [channels][channels]
  Float* first_bias = nullptr;     ///< [channels]
  Float* second = nullptr;         ///< [channels][audio]
  Float* second_bias = nullptr;    ///< [audio]
  Float* constants = nullptr;  ///< [clips][layers][2 channels]: biases and conditioning of gates
};

/// How long each of them is, in the order of StackParameters.
using StackSizes = std::array<std::ptrdiff_t, 12>;
StackSizes stack_sizes(const StackShape& shape, std::ptrdiff_t clips);

/// Parameters that lie one after the other.
StackParameters<float> consecutive(const StackSizes& sizes, float* all);

/// The same matrices, transposed; the rest is not looked at.
struct TransposedParameters {
  const float* gate = nullptr;      ///< [layers][taps][2 channels][channels]
  const float* residual = nullptr;  ///< [layers - 1][channels][channels]
  const float* skip = nullptr;      ///< [layers][channels][channels]
  const float* first = nullptr;     ///< [channels][channels]
  const float* second = nullptr;    ///< [audio][channels]
};

}  // namespace earpoint::training

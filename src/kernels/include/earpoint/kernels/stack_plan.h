#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <earpoint/kernels/tile_kernels.h>

namespace earpoint::kernels {

/// The dilated convolution of a layer.
struct DilatedConvolution {
  std::ptrdiff_t taps = 3;
  std::ptrdiff_t dilation = 1;
  /// Taps on both sides of the output (an odd number), else the last tap is on the output.
  bool acausal = true;

  /// Which tap reads the output's own sample.
  [[nodiscard]] std::ptrdiff_t centre() const { return acausal ? (taps - 1) / 2 : taps - 1; }
};

/// How a layer is computed for a waveform of a given length.
struct LayerPlan {
  PlaneOrder order;
  std::array<Sweep, 2> sweeps{};
  int sweep_count = 0;

  [[nodiscard]] std::span<const Sweep> used() const { return {sweeps.data(), sweep_count + 0U}; }
  [[nodiscard]] std::ptrdiff_t tiles() const;
};

/// Chooses order and schemes: taps that see only zeros are left out, three taps run by the scheme
/// that multiplies least, and small dilations run in segmented order.
/// @param samples  > 0
[[nodiscard]] LayerPlan plan_layer(const DilatedConvolution& convolution, std::ptrdiff_t samples);

}  // namespace earpoint::kernels

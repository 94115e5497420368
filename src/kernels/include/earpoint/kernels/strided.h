#pragma once

#include <span>
#include <vector>

namespace earpoint::kernels {

/// A one-dimensional convolution whose stride divides the sound: every output stands for `stride`
/// inputs and sees `padding` more on either side, zeros beyond the ends.
struct StridedShape {
  int stride = 1;
  int padding = 0;

  [[nodiscard]] int taps() const { return stride + 2 * padding; }
};

/// @param in      [inputs][samples], samples a multiple of the stride
/// @param weight  [outputs][inputs][taps]
/// @param bias    [outputs]
/// @return        [outputs][samples / stride]
[[nodiscard]] std::vector<float> convolve_strided(std::span<const float> in, int inputs,
                                                  std::span<const float> weight,
                                                  std::span<const float> bias, StridedShape shape);

/// The transposed convolution: every input gives `stride` outputs, and reaches `padding` further.
/// @param in      [inputs][samples]
/// @param weight  [inputs][outputs][taps]
/// @param bias    [outputs]
/// @return        [outputs][samples * stride]
[[nodiscard]] std::vector<float> convolve_transposed(std::span<const float> in, int inputs,
                                                     std::span<const float> weight,
                                                     std::span<const float> bias,
                                                     StridedShape shape);

}  // namespace earpoint::kernels

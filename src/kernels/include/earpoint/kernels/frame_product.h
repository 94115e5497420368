#pragma once

#include <cstddef>
#include <span>

#include <earpoint/kernels/aligned_floats.h>

namespace earpoint::kernels {

/// A matrix that multiplies many vectors, packed for the processor's vectors.
class FrameMatrix {
 public:
  FrameMatrix() = default;
  /// @param matrix  [outputs][inputs]
  FrameMatrix(std::span<const float> matrix, std::ptrdiff_t outputs);

  [[nodiscard]] std::ptrdiff_t inputs() const { return inputs_; }
  [[nodiscard]] std::ptrdiff_t outputs() const { return outputs_; }
  /// Floats that an output row takes: outputs() and what fills the last chunk.
  [[nodiscard]] std::ptrdiff_t row() const;

  /// out[frame] = (add ? out[frame] : bias) + matrix * in[frame]. Allocates nothing.
  /// @param in    frames rows, `in_stride` floats apart
  /// @param bias  [row()]; not looked at when adding
  /// @param out   frames rows, row() floats apart
  void multiply(const float* in, std::ptrdiff_t in_stride, std::ptrdiff_t frames, const float* bias,
                float* out, bool add) const;

 private:
  std::ptrdiff_t inputs_ = 0;
  std::ptrdiff_t outputs_ = 0;
  AlignedFloats packed_;  // [chunk][inputs][kChunk]
};

/// Outputs that are computed side by side.
inline constexpr std::ptrdiff_t kChunk = 16;

/// `values` and zeros, as long as an output row of a matrix with that many outputs.
[[nodiscard]] AlignedFloats padded_row(std::span<const float> values);

}  // namespace earpoint::kernels

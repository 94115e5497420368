#pragma once

#include "frame_planes.h"

#include <cstddef>
#include <vector>

namespace earpoint::training {

/// Sizes of the kernels over frames and ears.
struct KernelShape {
  std::ptrdiff_t past = 0;
  std::ptrdiff_t future = 0;
  std::vector<double> tails_s;
  std::vector<int> edges;  ///< of the bands, [bands + 1]

  [[nodiscard]] std::ptrdiff_t bands() const { return std::ssize(edges) - 1; }
  [[nodiscard]] std::ptrdiff_t shifts() const { return past + future + 1; }
  [[nodiscard]] std::ptrdiff_t taps() const { return shifts() + std::ssize(tails_s); }
  /// Of output ear, input ear, tap, band.
  [[nodiscard]] std::ptrdiff_t rows() const { return kEars * kEars * taps() * bands(); }
};

/// What kernels weigh in one clip: magnitudes of some frames before and after, and decaying means
/// of the past, m[t] = r m[t - 1] + (1 - r) x[t] with r = exp(-hop / time constant).
class KernelInputs {
 public:
  /// @param magnitudes  [2][bins][row], which must be zero beyond the frames
  KernelInputs(const KernelShape& shape, const FrameExtent& extent, const float* magnitudes);

  /// The row that a tap weighs.
  [[nodiscard]] const float* at(std::ptrdiff_t ear, std::ptrdiff_t tap, std::ptrdiff_t bin) const {
    return tap < shifts_ ? shifted_.data() + (ear * kBins + bin) * padded_row_ + tap
                         : tails_.data() + (((tap - shifts_) * kEars + ear) * kBins + bin) * row_;
  }

 private:
  std::ptrdiff_t shifts_;
  std::ptrdiff_t row_;
  std::ptrdiff_t padded_row_;
  std::vector<float> shifted_;
  std::vector<float> tails_;
};

/// An ear's magnitudes are the sum over both ears and the taps, each weighed by its band's kernel.
/// @param kernels   [KernelShape::rows()][row]
/// @param filtered  [2][bins][row]
void apply_kernels(const KernelShape& shape, const KernelInputs& inputs, std::ptrdiff_t row,
                   const float* kernels, float* filtered);

/// Its gradient by the kernels. @param by_kernels  shape of the kernels
void apply_kernels_back(const KernelShape& shape, const KernelInputs& inputs, std::ptrdiff_t row,
                        const float* by_filtered, float* by_kernels);

/// What one bin of one clip is made of, rows of frames.
struct BinRows {
  const float* spectrum[4];  ///< left real, imaginary; right
  const float* filtered[2];
  const float* gain[2];
};

/// What turns a bin's ears: of the source to the speaker's voice, and of the voice to the target.
struct BinTurns {
  float source_cosine[2], source_sine[2];
  float target_cosine[2], target_sine[2];
  float share[2];   ///< of the moved voice in the phase
  bool moves_ears;  ///< whether the rest is each ear's own sound moved, or unmoved
};

/// (max(filtered, 0) + 1e-3) * exp(gain between -3 and 2) with the phase of
/// share / 2 * moved voice + (1 - share) * rest, which is the source's ear, moved or not.
/// @param spectrum  receives left real, imaginary; right
void mix_bin(const BinRows& rows, const BinTurns& turns, std::ptrdiff_t row,
             float* const* spectrum);

/// Sums over a bin's frames of the gradient by what turns it.
struct BinSlopes {
  float by_share[2];
  float by_source_angle[2];  ///< by what the source's ears are turned forwards
  float by_target_angle[2];  ///< by what the target's ears are turned backwards
};

/// Gradient of mix_bin().
/// @param by_spectrum  as mix_bin()'s spectrum; @param by_filtered, by_gain  receive the gradient
BinSlopes mix_bin_back(const BinRows& rows, const BinTurns& turns, std::ptrdiff_t row,
                       const float* const* by_spectrum, float* const* by_filtered,
                       float* const* by_gain);

}  // namespace earpoint::training

#pragma once

#include "conditioning.h"

#include <complex>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/frame_product.h>

namespace earpoint::gtf {

/// Filters the source's spectra into the target's: kernels over frames, ears and tails, a gain for
/// each bin, and the phase for the moved speaker. Or estimates the dry speech.
class GtfFilter {
 public:
  GtfFilter(const GtfWeights& weights, std::ptrdiff_t most_frames);

  /// Forgets the tails.
  void reset();
  /// Brings the tails to a new scale of the input.
  void rescale(float factor);
  /// From here on. Allocates nothing.
  void condition(const GtfConditions& conditions);

  /// Reads the trunk's output for a block: kernels and gains of its frames. Allocates nothing.
  /// @param states  [frames][row of the trunk]
  void read(const float* states, std::ptrdiff_t state_row, std::ptrdiff_t frames);

  /// Filters one frame of the block. Frames must come in order. Allocates nothing.
  /// @param index       of the frame in the block
  /// @param magnitudes  [past + 1 + future][2][bins], the frame's own after the past ones
  /// @param spectrum    of the frame, [2][bins]; `filtered` likewise
  void filter(std::ptrdiff_t index, std::span<const float> magnitudes,
              std::span<const std::complex<float>> spectrum,
              std::span<std::complex<float>> filtered);

  /// Reads the trunk's dry-speech output for a block. Allocates nothing.
  void read_voice(const float* states, std::ptrdiff_t state_row, std::ptrdiff_t frames);

  /// The dry voice in one frame of the block, the same at both ears. Allocates nothing.
  /// @param magnitudes  of the frame, [2][bins]; `spectrum` and `voice` likewise
  void tell_voice(std::ptrdiff_t index, std::span<const float> magnitudes,
                  std::span<const std::complex<float>> spectrum,
                  std::span<std::complex<float>> voice) const;

 private:
  void filter_magnitudes(std::ptrdiff_t index, std::span<const float> magnitudes);
  void turn_phases(std::span<const std::complex<float>> spectrum,
                   std::span<std::complex<float>> filtered) const;

  GtfDescription description_;
  std::vector<int> edges_;
  kernels::FrameMatrix kernel_, gain_;
  kernels::Dense static_kernel_, static_gain_, phase_;
  std::vector<float> kernel_bias_own_, gain_bias_own_;
  AlignedFloats kernel_bias_, gain_bias_;  // with what the conditions add
  AlignedFloats kernels_, gains_;          // [most frames][row]
  std::vector<float> tail_share_;          // that a tail keeps from frame to frame
  std::vector<float> tails_;               // [tails][2][bins]
  std::vector<float> magnitude_;           // [2][bins], filtered
  std::vector<float> share_;               // [2][bands]: of the speaker's phase
  kernels::FrameMatrix dry_;
  kernels::Dense static_dry_;
  std::vector<float> dry_bias_own_;
  AlignedFloats dry_bias_, dry_gains_;
  bool is_corrected_ = false;
  std::vector<float> correction_;                     // [2][bins]: beyond the trained range
  std::vector<std::complex<float>> gather_, spread_;  // [2][bins]: ears to voice, voice to ears
};

}  // namespace earpoint::gtf

#pragma once

#include <cstdint>

#include <ATen/core/Tensor.h>

#include <earpoint/gtf/description.h>

namespace earpoint {

/// A layer over frames, of which a part is the same in all of a clip's frames.
struct FrameLayer {
  at::Tensor weight;  ///< [outputs][channels]
  at::Tensor still;   ///< [clips][outputs]: bias and what conditions add
};

/// What is filtered, without gradient. Rows as FrameExtent has them.
struct FilteredSound {
  at::Tensor spectrum;    ///< [clips][2][real, imaginary][bins][row]
  at::Tensor magnitudes;  ///< [clips][2][bins][row], zero beyond the frames
  std::int64_t samples = 0;
};

/// From the trunk's state to the target's spectra, and the gradient, clip by clip. An ear's
/// magnitudes are (max(kernels over frames and ears, 0) + 1e-3) * exp(gain between -3 and 2); its
/// phase is that of share / 2 * the speaker's voice as the target's ears hear it + (1 - share) *
/// the source.
/// @param state           [clips][channels][row]
/// @param kernels         outputs: of output ear, input ear, tap, band
/// @param gains           outputs: of ear and bin
/// @param share           [clips][2][bands]
/// @param source_delay_s  [clips][2]: by how much the source's ears hear the voice late
/// @param target_delay_s  [clips][2]
/// @return                [clips][2][real, imaginary][bins][row], rows as FrameExtent has them
at::Tensor filter_pass(const GtfDescription& description, const FilteredSound& sound,
                       const at::Tensor& state, const FrameLayer& kernels, const FrameLayer& gains,
                       const at::Tensor& share, const at::Tensor& source_delay_s,
                       const at::Tensor& target_delay_s);

}  // namespace earpoint

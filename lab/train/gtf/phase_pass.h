#pragma once

#include <cstdint>

#include <ATen/core/Tensor.h>

namespace earpoint {

/// From short-time spectra to the sound, after `rounds` of fast Griffin-Lim, and the gradient: each
/// round takes the phases of the short-time transform of what the spectra sound like, with
/// momentum, and keeps the magnitudes that the spectra came with.
/// @param spectrum  [clips][2][real, imaginary][bins][row], rows as FrameExtent has them; what it
///                  holds beyond the frames must be finite
/// @return          [clips][2][samples]
at::Tensor phase_pass(const at::Tensor& spectrum, int rounds, std::int64_t samples);

}  // namespace earpoint

#pragma once

#include <cstdint>

#include <ATen/core/Tensor.h>

namespace earpoint {

/// The short-time transform of Stft's default shape.
/// @param sounds  [clips][2][samples]
/// @return        [clips][2][257][frames], complex
at::Tensor short_time_spectrum(const at::Tensor& sounds);

/// Its inverse, by least squares. @return [clips][2][samples]
at::Tensor sound_of_spectrum(const at::Tensor& spectrum, std::int64_t samples);

/// sqrt(|x|^2 + 1e-8), whose slope is finite at zero.
at::Tensor magnitude_of(const at::Tensor& spectrum);

}  // namespace earpoint

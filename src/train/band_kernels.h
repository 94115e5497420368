#pragma once

#include <cstdint>
#include <vector>

#include <ATen/core/Tensor.h>

#include <earpoint/model/gtf.h>

namespace earpoint {

/// Decaying means of the past: m[t] = r m[t - 1] + (1 - r) x[t] with r = exp(-hop / time constant).
/// Without gradient.
/// @param magnitudes  [..., frames]
/// @return            the same shape
at::Tensor decaying_mean(const at::Tensor& magnitudes, double time_constant_s);

/// Filters magnitudes across frames and ears, band by band: the magnitude of an ear is the sum over
/// both ears, over frames t - past to t + future and over the tails, each weighed by the kernel of
/// its band. On the processor only; the gradient goes to the kernels alone.
/// @param magnitudes  [clips][2][bins][frames]
/// @param kernels     [clips][2 * 2 * taps * bands][frames]: of output ear, input ear, tap, band
/// @return            [clips][2][bins][frames]
at::Tensor apply_band_kernels(const GtfDescription& description, const at::Tensor& magnitudes,
                              const at::Tensor& kernels);

}  // namespace earpoint

#pragma once

#include <cstdint>

#include <ATen/core/Tensor.h>

#include <earpoint/train/gtf_learner.h>

namespace earpoint {

/// What some clips of a batch need to know of all of it.
struct BatchShare {
  double clips = 1.0;     ///< these over all
  double loudness = 0.0;  ///< loudness_of() all targets, in sum
};

/// Short-time spectra as FrameExtent has them. @param sound  [clips][2][samples]
/// @return [clips][2][real, imaginary][bins][row]
at::Tensor spectrum_planes(const at::Tensor& sound);

/// What the phase between the ears is weighed by, summed over all bins.
/// @param spectrum  of spectrum_planes() @param samples  of the sound
double loudness_of(const at::Tensor& spectrum, std::int64_t samples);

/// These clips' share of the terms of the loss that compare short-time spectra: magnitudes, their
/// logarithms, the depth of modulation and the phase between the ears. Loss and gradient are
/// computed together, clip by clip.
/// @param sound   [clips][2][samples]
/// @param wanted  spectrum_planes() of the target
at::Tensor spectral_loss(const GtfLossWeights& weights, const at::Tensor& sound,
                         const at::Tensor& wanted, const BatchShare& share);

}  // namespace earpoint

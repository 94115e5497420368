#pragma once

#include <cstdint>

#include <ATen/core/Tensor.h>

#include <earpoint/gtf/description.h>

namespace earpoint {

/// A sound in the short-time domain, and what the network is told of it. Rows as FrameExtent has
/// them.
struct SoundFeatures {
  std::int64_t samples = 0;
  at::Tensor spectrum;   ///< [clips][2][real, imaginary][bins][row]
  at::Tensor magnitude;  ///< [clips][2][bins][row]: sqrt(|x|^2 + 1e-8), zero beyond the frames
  at::Tensor features;   ///< [clips][frame features][row]
  at::Tensor summary;    ///< [clips][summary features]
};

/// Without gradient. @param sound  [clips][2][samples]
SoundFeatures sound_features(const GtfDescription& description, const at::Tensor& sound);

}  // namespace earpoint

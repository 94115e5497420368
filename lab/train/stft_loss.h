#pragma once

#include <cstdint>

#include <ATen/core/Tensor.h>

namespace earpoint {

/// Short-time magnitudes as the published loss and metric take them: 512 points, a periodic Hamming
/// window of 400 in their middle, zeros outside the signal, frame k centred at k * hop.
class ShortTimeMagnitude {
 public:
  ShortTimeMagnitude(std::int64_t hop_samples, const at::Device& device);

  /// sqrt(max(re^2 + im^2, 1e-7)); without gradient where the maximum is the constant.
  /// @param signals  [signals][samples]
  /// @return         [signals][257][frames]
  [[nodiscard]] at::Tensor clamped(const at::Tensor& signals) const;

  /// sqrt(re^2 + im^2), for metrics.
  [[nodiscard]] at::Tensor plain(const at::Tensor& signals) const;

 private:
  [[nodiscard]] at::Tensor power(const at::Tensor& signals) const;

  std::int64_t hop_samples_;
  at::Tensor window_;
};

/// Mean absolute difference of the clamped magnitudes.
/// @param prediction, target  [clips][channels][samples]
at::Tensor magnitude_loss(const ShortTimeMagnitude& magnitude, const at::Tensor& prediction,
                          const at::Tensor& target);

/// The same, plus the mean absolute difference of the magnitudes' logarithms: quiet parts count as
/// much as loud ones.
at::Tensor log_magnitude_loss(const ShortTimeMagnitude& magnitude, const at::Tensor& prediction,
                              const at::Tensor& target);

/// The metric Mag of each clip: the sum over the channels of the mean absolute difference of the
/// plain magnitudes.
/// @return [clips]
at::Tensor magnitude_distance(const ShortTimeMagnitude& magnitude, const at::Tensor& prediction,
                              const at::Tensor& target);

}  // namespace earpoint

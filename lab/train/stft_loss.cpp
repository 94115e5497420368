#include "stft_loss.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/hamming_window.h>
#include <ATen/ops/stft.h>
#include <ATen/ops/view_as_real.h>

#include <earpoint/audio/stft.h>

namespace earpoint {
namespace {

constexpr std::int64_t kFftSize = StftShape{}.fft_size;
constexpr std::int64_t kWindowSize = StftShape{}.window_size;
constexpr double kSmallestPower = 1e-7;

at::Tensor one_signal_per_row(const at::Tensor& sound) {
  return sound.reshape({sound.size(0) * sound.size(1), sound.size(2)});
}

at::Tensor mean_absolute(const at::Tensor& difference) { return difference.abs().mean(); }

}  // namespace

ShortTimeMagnitude::ShortTimeMagnitude(std::int64_t hop_samples, const at::Device& device)
    : hop_samples_(hop_samples),
      window_(at::hamming_window(kWindowSize, /*periodic=*/true).to(device)) {}

at::Tensor ShortTimeMagnitude::power(const at::Tensor& signals) const {
  const at::Tensor padded = at::constant_pad_nd(signals, {kFftSize / 2, kFftSize / 2});
  const at::Tensor spectrum =
      at::stft(padded, kFftSize, hop_samples_, kWindowSize, window_, /*normalized=*/false,
               /*onesided=*/true, /*return_complex=*/true);
  return at::view_as_real(spectrum).square().sum(at::IntArrayRef({3}));
}

at::Tensor ShortTimeMagnitude::clamped(const at::Tensor& signals) const {
  return power(signals).clamp_min(kSmallestPower).sqrt();
}

at::Tensor ShortTimeMagnitude::plain(const at::Tensor& signals) const {
  return power(signals).sqrt();
}

at::Tensor magnitude_loss(const ShortTimeMagnitude& magnitude, const at::Tensor& prediction,
                          const at::Tensor& target) {
  return mean_absolute(magnitude.clamped(one_signal_per_row(prediction)) -
                       magnitude.clamped(one_signal_per_row(target)));
}

at::Tensor log_magnitude_loss(const ShortTimeMagnitude& magnitude, const at::Tensor& prediction,
                              const at::Tensor& target) {
  const at::Tensor predicted = magnitude.clamped(one_signal_per_row(prediction));
  const at::Tensor wanted = magnitude.clamped(one_signal_per_row(target));
  return mean_absolute(predicted.log() - wanted.log()) + mean_absolute(predicted - wanted);
}

at::Tensor magnitude_distance(const ShortTimeMagnitude& magnitude, const at::Tensor& prediction,
                              const at::Tensor& target) {
  const at::Tensor difference =
      magnitude.plain(one_signal_per_row(prediction)) - magnitude.plain(one_signal_per_row(target));
  return difference.abs()
      .mean(at::IntArrayRef({1, 2}))
      .reshape({prediction.size(0), prediction.size(1)})
      .sum(1);
}

}  // namespace earpoint

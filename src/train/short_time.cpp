#include "short_time.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/constant_pad_nd.h>
#include <ATen/ops/hamming_window.h>
#include <ATen/ops/istft.h>
#include <ATen/ops/stft.h>
#include <ATen/ops/view_as_real.h>

#include <earpoint/model/gtf.h>

namespace earpoint {
namespace {

using D = GtfDescription;

constexpr double kPowerFloor = 1e-8;

at::Tensor window_on(const at::Device& device) {
  return at::hamming_window(D::kFrameSamples, /*periodic=*/true).to(device);
}

}  // namespace

at::Tensor short_time_spectrum(const at::Tensor& sounds) {
  constexpr std::int64_t kPad = D::kFftSize / 2;
  const at::Tensor rows = at::constant_pad_nd(sounds.flatten(0, 1), {kPad, kPad});
  return at::stft(rows, D::kFftSize, D::kHop, D::kFrameSamples, window_on(sounds.device()),
                  /*normalized=*/false, /*onesided=*/true, /*return_complex=*/true)
      .unflatten(0, {sounds.size(0), sounds.size(1)});
}

at::Tensor sound_of_spectrum(const at::Tensor& spectrum, std::int64_t samples) {
  return at::istft(spectrum.flatten(0, 1), D::kFftSize, D::kHop, D::kFrameSamples,
                   window_on(spectrum.device()), /*center=*/true, /*normalized=*/false,
                   /*onesided=*/true, samples)
      .unflatten(0, {spectrum.size(0), spectrum.size(1)});
}

at::Tensor magnitude_of(const at::Tensor& spectrum) {
  return (at::view_as_real(spectrum).square().sum(at::IntArrayRef({-1})) + kPowerFloor).sqrt();
}

}  // namespace earpoint

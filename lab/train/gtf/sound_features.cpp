#include "sound_features.h"

#include "frame_planes.h"

#include <cmath>
#include <vector>

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/matmul.h>
#include <ATen/ops/zeros.h>

#include <earpoint/core/ears.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using D = GtfDescription;
using training::FrameExtent;
using training::kBins;

/// Correlation of the ears over lags from their mean cross-spectrum: [real, imaginary][bins][lags].
struct LagTables {
  at::Tensor cosine;
  at::Tensor sine;

  LagTables() {
    const at::TensorOptions real = at::TensorOptions().dtype(at::kDouble);
    const at::Tensor angle = at::arange(D::kBins, real).unsqueeze(1) *
                             at::arange(-D::kLags, D::kLags + 1, real).unsqueeze(0) *
                             (2.0 * kPi / D::kFftSize);
    cosine = angle.cos().to(at::kFloat);
    sine = angle.sin().to(at::kFloat);
  }
};

/// Results of the passes over one clip's spectrum.
struct Found {
  float* magnitude;  ///< [2][bins][row]
  float* power;      ///< [2][bands][row]
  float* common;     ///< [2][bands][row]: real and imaginary part of the cross-spectrum
  float* mean;       ///< [2][bins]: cross-spectrum over its strength, all frames together
};

void listen(const FrameExtent& extent, const std::vector<int>& edges, const float* spectrum,
            const Found& found) {
  const std::ptrdiff_t row = extent.row();
  const std::ptrdiff_t plane = extent.plane();
  const std::ptrdiff_t bands = std::ssize(edges) - 1;
  std::vector<float> strength(static_cast<std::size_t>(row));
  for (std::ptrdiff_t band = 0; band < bands; ++band) {
    float* power_left = found.power + band * row;
    float* power_right = power_left + bands * row;
    float* common_re = found.common + band * row;
    float* common_im = common_re + bands * row;
    for (std::ptrdiff_t bin = edges[band]; bin < edges[band + 1]; ++bin) {
      const float* __restrict left_re = spectrum + bin * row;
      const float* __restrict left_im = left_re + plane;
      const float* __restrict right_re = left_im + plane;
      const float* __restrict right_im = right_re + plane;
      float* __restrict left = found.magnitude + bin * row;
      float* __restrict right = left + plane;
      float sum_re = 0.0F;
      float sum_im = 0.0F;
      float sum = 0.0F;
      for (std::ptrdiff_t t = 0; t < extent.frames(); ++t) {
        const float a = left_re[t] * left_re[t] + left_im[t] * left_im[t] + gtf::kPowerFloor;
        const float b = right_re[t] * right_re[t] + right_im[t] * right_im[t] + gtf::kPowerFloor;
        const float re = left_re[t] * right_re[t] + left_im[t] * right_im[t];
        const float im = left_im[t] * right_re[t] - left_re[t] * right_im[t];
        left[t] = std::sqrt(a);
        right[t] = std::sqrt(b);
        power_left[t] += a;
        power_right[t] += b;
        common_re[t] += re;
        common_im[t] += im;
        strength[t] = std::sqrt(re * re + im * im);
      }
      for (std::ptrdiff_t t = 0; t < extent.frames(); ++t) {
        sum_re += left_re[t] * right_re[t] + left_im[t] * right_im[t];
        sum_im += left_im[t] * right_re[t] - left_re[t] * right_im[t];
        sum += strength[t];
      }
      found.mean[bin] = sum_re / (sum + gtf::kStrengthFloor);
      found.mean[kBins + bin] = sum_im / (sum + gtf::kStrengthFloor);
    }
  }
}

}  // namespace

SoundFeatures sound_features(const GtfDescription& description, const at::Tensor& sound) {
  const at::NoGradGuard no_gradients;
  static const LagTables kTables;
  const std::vector<int> edges = gtf_band_edges(description.bands).value();
  const std::int64_t clips = sound.size(0);
  const std::int64_t bands = description.bands;
  const FrameExtent extent{sound.size(2)};
  const at::Tensor sounds = sound.contiguous();
  SoundFeatures heard;
  heard.samples = sound.size(2);
  heard.spectrum = at::empty({clips, kEars, 2, kBins, extent.row()});
  heard.magnitude = at::zeros({clips, kEars, kBins, extent.row()});
  const at::Tensor power = at::zeros({clips, kEars, bands, extent.row()});
  const at::Tensor common = at::zeros({clips, 2, bands, extent.row()});
  const at::Tensor mean_cross = at::zeros({clips, 2, kBins});
  const auto of = [](const at::Tensor& tensor, std::int64_t clip) {
    return tensor.data_ptr<float>() + clip * tensor.stride(0);
  };
  for (std::int64_t clip = 0; clip < clips; ++clip) {
    training::analyse(extent, of(sounds, clip), of(heard.spectrum, clip));
    listen(extent, edges, of(heard.spectrum, clip),
           {of(heard.magnitude, clip), of(power, clip), of(common, clip), of(mean_cross, clip)});
  }

  // Per band: power of each ear, and the ears' coherence.
  const at::Tensor scale = (power.select(1, 0) * power.select(1, 1) + gtf::kCrossFloor).sqrt();
  const at::Tensor likeness = common / scale.unsqueeze(1);
  heard.features = at::cat({(power + gtf::kBandFloor).log().div(gtf::kBandLogScale).flatten(1, 2),
                            likeness.flatten(1, 2)},
                           1);

  // For the whole window: loud frames have more weight.
  constexpr std::int64_t kTime[] = {-1};
  const at::IntArrayRef over_time(kTime);
  at::Tensor loudness = power.sum(at::IntArrayRef({1}));
  loudness = loudness / (loudness.sum(over_time, true) + gtf::kStrengthFloor);
  const at::Tensor mean = power.sum(over_time) / static_cast<double>(extent.frames());
  const at::Tensor between =
      ((mean.select(1, 0) + gtf::kBalanceFloor) / (mean.select(1, 1) + gtf::kBalanceFloor))
          .log()
          .div(2);
  const at::Tensor together =
      (mean.sum(at::IntArrayRef({1})) + gtf::kBandFloor).log().div(gtf::kBandLogScale);
  const at::Tensor over_lags = (at::matmul(mean_cross.select(1, 0), kTables.cosine) -
                                at::matmul(mean_cross.select(1, 1), kTables.sine)) /
                               gtf::kLagScale;
  heard.summary = at::cat(
      {(likeness * loudness.unsqueeze(1)).sum(over_time).flatten(1), between, together, over_lags},
      1);
  return heard;
}

}  // namespace earpoint

#include "spectral_loss.h"

#include "frame_planes.h"
#include "loss_kernels.h"

#include <array>
#include <vector>

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/empty_like.h>
#include <ATen/ops/full.h>
#include <torch/csrc/autograd/custom_function.h>

#include <earpoint/core/ears.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;
using training::FrameExtent;
using training::kBins;
using training::RowWeights;

/// Share of a clip's mean magnitude below which the depth of modulation counts it as silence.
constexpr double kDepth = 1e-2;

template <class Float>
std::array<Float*, 4> planes_at(const FrameExtent& extent, Float* spectrum, std::ptrdiff_t bin) {
  Float* first = spectrum + bin * extent.row();
  const std::ptrdiff_t plane = extent.plane();
  return {first, first + plane, first + 2 * plane, first + 3 * plane};
}

const float* of_clip(const at::Tensor& tensor, std::int64_t clip) {
  return tensor.data_ptr<float>() + clip * tensor.stride(0);
}

/// One clip's loss and its gradient by the spectrum.
double clip_loss(const FrameExtent& extent, const float* found, const float* right,
                 RowWeights weights, float* slopes) {
  if (weights.modulation > 0.0F) {
    double sum = 0.0;
    for (std::ptrdiff_t bin = 0; bin < kBins; ++bin) {
      sum += training::magnitude_of_bin(planes_at(extent, right, bin).data(), extent.frames(),
                                        extent.row());
    }
    const double mean = sum / static_cast<double>(kEars * kBins * extent.frames());
    weights.modulation_floor = static_cast<float>(mean * kDepth + 1e-6);
  }
  double loss = 0.0;
  for (std::ptrdiff_t bin = 0; bin < kBins; ++bin) {
    const auto f = planes_at(extent, found, bin);
    const auto r = planes_at(extent, right, bin);
    loss +=
        training::loss_of_bin({{f[0], f[1], f[2], f[3]}, {r[0], r[1], r[2], r[3]}}, weights,
                              extent.frames(), extent.row(), planes_at(extent, slopes, bin).data());
  }
  return loss;
}

class SpectralLoss : public torch::autograd::Function<SpectralLoss> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& sound,
                            const at::Tensor& wanted, const RowWeights* weights) {
    const FrameExtent extent{sound.size(2)};
    at::Tensor by_sound = at::empty_like(sound);
    std::vector<float> found(static_cast<std::size_t>(extent.spectrum()));
    std::vector<float> slopes(found.size());
    double loss = 0.0;
    for (std::int64_t clip = 0; clip < sound.size(0); ++clip) {
      training::analyse(extent, of_clip(sound, clip), found.data());
      loss += clip_loss(extent, found.data(), of_clip(wanted, clip), *weights, slopes.data());
      training::analyse_back(extent, slopes.data(),
                             by_sound.data_ptr<float>() + clip * by_sound.stride(0));
    }
    context->save_for_backward({by_sound});
    return at::full({}, loss, at::TensorOptions().dtype(at::kFloat));
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    return {context->get_saved_variables()[0] * gradients[0], {}, {}};
  }
};

}  // namespace

at::Tensor spectrum_planes(const at::Tensor& sound) {
  const at::NoGradGuard no_gradients;
  const FrameExtent extent{sound.size(2)};
  const at::Tensor sounds = sound.contiguous();
  at::Tensor spectrum = at::empty({sound.size(0), kEars, 2, kBins, extent.row()});
  for (std::int64_t clip = 0; clip < sound.size(0); ++clip) {
    training::analyse(extent, of_clip(sounds, clip),
                      spectrum.data_ptr<float>() + clip * spectrum.stride(0));
  }
  return spectrum;
}

double loudness_of(const at::Tensor& spectrum, std::int64_t samples) {
  const FrameExtent extent{samples};
  double loudness = 0.0;
  for (std::int64_t clip = 0; clip < spectrum.size(0); ++clip) {
    for (std::ptrdiff_t bin = 0; bin < kBins; ++bin) {
      loudness += training::loudness_of_bin(planes_at(extent, of_clip(spectrum, clip), bin).data(),
                                            extent.frames(), extent.row());
    }
  }
  return loudness;
}

at::Tensor spectral_loss(const GtfLossWeights& weights, const at::Tensor& sound,
                         const at::Tensor& wanted, const BatchShare& share) {
  const FrameExtent extent{sound.size(2)};
  const double rows = static_cast<double>(sound.size(0) * kEars * kBins) / share.clips;
  const double values = rows * static_cast<double>(extent.frames());
  RowWeights row;
  // Summed over the ears, like the metric.
  row.magnitude = static_cast<float>(2.0 / values);
  row.log_magnitude = static_cast<float>(weights.log_magnitude / values);
  row.modulation = static_cast<float>(weights.modulation / rows);
  if (weights.phase_difference > 0) {
    EARPOINT_CHECK(share.loudness > 0);
    row.phase_difference = static_cast<float>(weights.phase_difference / share.loudness);
  }
  return SpectralLoss::apply(sound.contiguous(), wanted, &row);
}

}  // namespace earpoint

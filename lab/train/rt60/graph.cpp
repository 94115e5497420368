#include "graph.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/linear.h>
#include <ATen/ops/ones_like.h>
#include <ATen/ops/where.h>

#include <earpoint/audio/stft.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

at::Tensor scaled_to(const at::Tensor& sounds, double rms) {
  constexpr double kSilence = 1e-12;
  const at::Tensor power = sounds.square().mean(1, /*keepdim=*/true).clamp_min(kSilence);
  return sounds * at::where(power > kSilence, rms / power.sqrt(), at::ones_like(power));
}

/// [clips][2][samples] to [clips * 2 * seconds][kWindowSamples].
at::Tensor whole_seconds(const at::Tensor& sound) {
  constexpr std::int64_t kSecond = Rt60Description::kWindowSamples;
  const std::int64_t seconds = sound.size(2) / kSecond;
  return sound.narrow(2, 0, seconds * kSecond).reshape({-1, kSecond});
}

}  // namespace

Rt60Graph::Rt60Graph(const Rt60EstimatorWeights& weights, const at::Device& device)
    : description(weights.description),
      tensors(weights.tensors, device),
      magnitude(StftShape{}.hop, device) {}

at::Tensor Rt60Graph::estimate_s(const at::Tensor& sounds, GraphMode mode) const {
  const at::Tensor scaled =
      description.input_rms ? scaled_to(sounds, *description.input_rms) : sounds;
  const at::Tensor spectrum =
      sounds.requires_grad() ? magnitude.clamped(scaled) : magnitude.plain(scaled);
  const at::Tensor map =
      resnet18(tensors, "feature_extraction", spectrum.log1p().unsqueeze(1), mode);
  const at::Tensor feature = map.mean(at::IntArrayRef({2, 3}));
  return at::linear(feature, tensors.parameter("predictor.0.weight"),
                    tensors.parameter("predictor.0.bias"))
      .squeeze(1);
}

at::Tensor reverberation_error_s(const Rt60Graph& estimator, const at::Tensor& found,
                                 const at::Tensor& right) {
  EARPOINT_CHECK(right.size(2) >= Rt60Description::kWindowSamples);
  const at::Tensor ours = estimator.estimate_s(whole_seconds(found), GraphMode::evaluation);
  const at::Tensor theirs = estimator.estimate_s(whole_seconds(right), GraphMode::evaluation);
  return (ours - theirs.detach()).abs().mean();
}

}  // namespace earpoint

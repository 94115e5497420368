#include "loss.h"

#include "decay_error.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/log10.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>
#include <ATen/ops/zeros_like.h>

#include <earpoint/error.h>
#include <earpoint/gtf/description.h>

namespace earpoint {
namespace {

/// Radians, below which an error of direction counts by its square.
constexpr double kSmallDirection = 0.05;

at::Tensor energy(const at::Tensor& sound) { return sound.square().sum(at::IntArrayRef({2})); }

at::Tensor decibel(const at::Tensor& power) { return power.log10() * 10; }

/// Level of the left ear over that of the right: [clips].
at::Tensor level_difference_db(const at::Tensor& sound) {
  const at::Tensor e = energy(sound);
  return decibel(e.select(1, 0) / (e.select(1, 1) + 1e-5) + 1e-9);
}

at::Tensor level_db(const at::Tensor& sound) { return decibel(energy(sound) + 1e-3); }

at::Tensor unit(const at::Tensor& level) {
  return level / (level.square().sum(at::IntArrayRef({1}), true) + 1e-6).sqrt();
}

at::Tensor log_distance(const at::Tensor& point) {
  return (point.square().sum(at::IntArrayRef({1})) + 1e-6).log() / 2;
}

}  // namespace

at::Tensor place_error(const SpeakerPlace& speaker, const GtfTruth& truth) {
  const at::Tensor& found = speaker.position_m;
  const at::Tensor& wanted = truth.speaker_m;
  const auto squared = [](const at::Tensor& v) { return v.square().sum(at::IntArrayRef({1})); };
  // The square of a small error would hardly count beside those of speakers outside the picture.
  const at::Tensor direction =
      (squared(unit(found.narrow(1, 0, 2)) - unit(wanted.narrow(1, 0, 2))) +
       kSmallDirection * kSmallDirection)
          .sqrt() -
      kSmallDirection;
  const at::Tensor distance = (log_distance(found) - log_distance(wanted)).abs();
  const at::Tensor height = (found.select(1, 2) - wanted.select(1, 2)).abs();
  const at::Tensor is_known = (squared(truth.speaker_heading) > 0.5).to(at::kFloat);
  const at::Tensor heading = squared(speaker.heading - truth.speaker_heading) * is_known;
  // Zeros stand for an unknown position.
  const at::Tensor is_placed = (squared(wanted) > 0.0).to(at::kFloat);
  return ((direction + distance + 0.5 * height + 0.2 * heading) * is_placed).mean();
}

at::Tensor dry_magnitudes(const at::Tensor& dry) {
  // The transform needs two ears: the second one is silent.
  const at::Tensor sounds = at::stack({dry, at::zeros_like(dry)}, 1);
  return spectrum_planes(sounds)
      .select(1, 0)
      .square()
      .sum(at::IntArrayRef({1}))
      .sqrt()
      .narrow(2, 0, 1 + dry.size(1) / GtfDescription::kHop);
}

at::Tensor gtf_loss(const GtfLossWeights& weights, const GtfOutput& output, const GtfTruth& truth,
                    const BatchShare& share, const Rt60Graph* estimator) {
  at::Tensor loss = at::zeros({});
  if (weights.level_difference > 0) {
    loss = loss +
           (level_difference_db(output.sound) - level_difference_db(truth.target)).abs().mean() *
               weights.level_difference;
  }
  if (weights.level > 0 || weights.squared_level > 0) {
    const at::Tensor off = level_db(output.sound) - level_db(truth.target);
    loss = loss + off.abs().mean() * weights.level + off.square().mean() * weights.squared_level;
  }
  if (weights.decay > 0) {
    loss = loss + decay_error_db(truth.dry, output.sound, truth.target) * weights.decay;
  }
  if (weights.reverberation > 0) {
    EARPOINT_CHECK(estimator != nullptr);
    loss = loss +
           reverberation_error_s(*estimator, output.sound, truth.target) * weights.reverberation;
  }
  if (weights.dry_voice > 0) {
    loss = loss + (output.dry_magnitude - truth.dry_magnitude).abs().mean() * weights.dry_voice;
  }
  if (weights.place > 0 && output.speaker) {
    loss = loss + place_error(*output.speaker, truth) * weights.place;
  }
  return loss * share.clips + spectral_loss(weights, output.sound, truth.spectrum, share);
}

}  // namespace earpoint

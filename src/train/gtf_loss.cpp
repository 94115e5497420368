#include "gtf_loss.h"

#include "decay_error.h"
#include "short_time.h"

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/log10.h>
#include <ATen/ops/view_as_real.h>

#include <earpoint/core/error.h>

namespace earpoint {
namespace {

// Magnitudes below it do not count on the logarithmic scale: the floor of a quiet room.
constexpr double kQuietMagnitude = 0.02;

at::Tensor energy(const at::Tensor& sound) { return sound.square().sum(at::IntArrayRef({2})); }

at::Tensor decibel(const at::Tensor& power) { return power.log10() * 10; }

/// Level of the left ear over that of the right: [clips].
at::Tensor level_difference_db(const at::Tensor& sound) {
  const at::Tensor e = energy(sound);
  return decibel(e.select(1, 0) / (e.select(1, 1) + 1e-5) + 1e-9);
}

at::Tensor level_db(const at::Tensor& sound) { return decibel(energy(sound) + 1e-3); }

at::Tensor cross_spectrum(const at::Tensor& s) { return s.select(1, 0) * s.select(1, 1).conj(); }

/// How far the phase between the ears is off, loud bins first.
/// @param loudness  the sum of all bins' weights in the batch
at::Tensor phase_difference_error(const at::Tensor& predicted, const at::Tensor& wanted,
                                  double loudness) {
  const at::Tensor ours = cross_spectrum(predicted);
  const at::Tensor theirs = cross_spectrum(wanted);
  const at::Tensor strength = magnitude_of(theirs);
  const at::Tensor distance = magnitude_of(ours / magnitude_of(ours) - theirs / strength);
  return (strength.sqrt() * distance).sum() / loudness;
}

/// How far the depth of modulation is off: of every bin, the spread of its level over the window in
/// nepers. Reverberation fills the gaps of speech and lessens it, as does what a network is unsure
/// of.
/// @param found, right  magnitudes [clips][2][bins][frames]
at::Tensor modulation_error(const at::Tensor& found, const at::Tensor& right) {
  constexpr double kDepth = 1e-2;  // of a clip's mean magnitude: what lies below is silence
  const at::Tensor floor = right.mean(at::IntArrayRef({1, 2, 3}), true) * kDepth + 1e-6;
  const auto spread = [&](const at::Tensor& magnitude) {
    const at::Tensor level = (magnitude + floor).log();
    const at::Tensor off = level - level.mean(at::IntArrayRef({3}), true);
    return (off.square().mean(at::IntArrayRef({3})) + 1e-4).sqrt();
  };
  return (spread(found) - spread(right)).abs().mean();
}

at::Tensor unit(const at::Tensor& level) {
  return level / (level.square().sum(at::IntArrayRef({1}), true) + 1e-6).sqrt();
}

at::Tensor log_distance(const at::Tensor& point) {
  return (point.square().sum(at::IntArrayRef({1})) + 1e-6).log() / 2;
}

at::Tensor place_error(const SpeakerPlace& speaker, const GtfTruth& truth) {
  const at::Tensor& found = speaker.position_m;
  const at::Tensor& wanted = truth.speaker_m;
  const auto squared = [](const at::Tensor& v) { return v.square().sum(at::IntArrayRef({1})); };
  const at::Tensor direction = squared(unit(found.narrow(1, 0, 2)) - unit(wanted.narrow(1, 0, 2)));
  const at::Tensor distance = (log_distance(found) - log_distance(wanted)).abs();
  const at::Tensor height = (found.select(1, 2) - wanted.select(1, 2)).abs();
  const at::Tensor is_known = (squared(truth.speaker_heading) > 0.5).to(at::kFloat);
  const at::Tensor heading = squared(speaker.heading - truth.speaker_heading) * is_known;
  return (direction + distance + 0.5 * height + 0.2 * heading).mean();
}

}  // namespace

double loudness_of(const at::Tensor& target) {
  const at::NoGradGuard no_gradients;
  return magnitude_of(cross_spectrum(short_time_spectrum(target))).sqrt().sum().item<double>();
}

at::Tensor gtf_loss(const GtfLossWeights& weights, const GtfOutput& output, const GtfTruth& truth,
                    const BatchShare& share, const Rt60Graph* estimator) {
  const at::Tensor predicted = short_time_spectrum(output.sound);
  const at::Tensor wanted = short_time_spectrum(truth.target);
  const at::Tensor found = magnitude_of(predicted);
  const at::Tensor right = magnitude_of(wanted);
  // Summed over the ears, as the metric has it.
  at::Tensor loss = (found - right).abs().mean() * 2;
  if (weights.log_magnitude > 0) {
    loss = loss + ((found + kQuietMagnitude).log() - (right + kQuietMagnitude).log()).abs().mean() *
                      weights.log_magnitude;
  }
  if (weights.level_difference > 0) {
    loss = loss +
           (level_difference_db(output.sound) - level_difference_db(truth.target)).abs().mean() *
               weights.level_difference;
  }
  if (weights.level > 0) {
    loss = loss + (level_db(output.sound) - level_db(truth.target)).abs().mean() * weights.level;
  }
  if (weights.modulation > 0) {
    loss = loss + modulation_error(found, right) * weights.modulation;
  }
  if (weights.decay > 0) {
    loss = loss + decay_error_db(truth.dry, output.sound, truth.target) * weights.decay;
  }
  if (weights.reverberation > 0) {
    EARPOINT_CHECK(estimator != nullptr);
    loss = loss +
           reverberation_error_s(*estimator, output.sound, truth.target) * weights.reverberation;
  }
  if (weights.place > 0 && output.speaker) {
    loss = loss + place_error(*output.speaker, truth) * weights.place;
  }
  loss = loss * share.clips;
  if (weights.phase_difference > 0) {
    loss = loss +
           phase_difference_error(predicted, wanted, share.loudness) * weights.phase_difference;
  }
  return loss;
}

}  // namespace earpoint

#include <earpoint/gtf/synthesizer.h>

#include "warnings.h"

#include <utility>

#include <earpoint/gtf/level.h>
#include <earpoint/gtf/view.h>

namespace earpoint {

GtfSynthesizer::GtfSynthesizer(std::shared_ptr<const GtfWeights> weights, double horizontal_fov_rad,
                               const GtfUse& use)
    : weights_(std::move(weights)),
      horizontal_fov_rad_(horizontal_fov_rad),
      use_(use),
      network_(*weights_) {
  network_.ask_for_texture(use.texture);
}

GtfSynthesizer::GtfSynthesizer(GtfWeights weights, double horizontal_fov_rad, const GtfUse& use)
    : GtfSynthesizer(std::make_shared<const GtfWeights>(std::move(weights)), horizontal_fov_rad,
                     use) {}

std::unique_ptr<AcousticSynthesizer> GtfSynthesizer::twin() const {
  return std::make_unique<GtfSynthesizer>(weights_, horizontal_fov_rad_, use_);
}

WindowShape GtfSynthesizer::window_shape(int /*source_rate_hz*/) const {
  const std::ptrdiff_t samples = network_.description().window_samples;
  return {.sample_rate_hz = GtfDescription::kSampleRateHz,
          .samples = samples,
          .overlap = samples / 4,
          .context = 0,
          .pose_step = GtfDescription::kHop};
}

double GtfSynthesizer::ambient_cutoff_hz() const {
  return network_.description().highpass_cutoff_hz.value_or(0.0);
}

PictureUse GtfSynthesizer::picture_use() const {
  return network_.description().picture_px > 0 ? PictureUse::if_there : PictureUse::never;
}

std::vector<std::string> GtfSynthesizer::warnings(const RenderOutline& outline) const {
  return gtf_warnings(network_.description(), outline, horizontal_fov_rad_);
}

void GtfSynthesizer::observe(const Observation& observation) {
  const int size = network_.description().picture_px;
  const View seen{observation.picture, observation.speaker_box};
  if (!seen_ || *seen_ != seen) {
    const GtfView view = gtf_view(size > 0 ? seen.picture.get() : nullptr, seen.speaker_box,
                                  horizontal_fov_rad_, size > 0 ? size : 1);
    network_.set_picture(view.picture, view.speaker_box);
    seen_ = seen;
  }
  speaker_m_ = observation.speaker_m;
  sound_ = observation.sound;
}

Waveform GtfSynthesizer::synthesize(const Pose& source_from_target) {
  return synthesize_along({&source_from_target, 1});
}

Waveform GtfSynthesizer::synthesize_along(std::span<const Pose> path) {
  network_.set_pose(path.front(), speaker_m_);
  Waveform result(2, sound_.samples(), sound_.sample_rate_hz());
  network_.synthesize(sound_.planar(), path, result.planar());
  if (!use_.limits_level) {
    limit_loudness(sound_, result);
    return result;
  }
  limit_level(sound_, network_.expected_gain(),
              gtf_level_tolerance(path, network_.description().training_range),
              speaker_m_.has_value(), result);
  return result;
}

}  // namespace earpoint

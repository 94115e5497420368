#include <earpoint/vam/synthesizer.h>

#include <utility>

#include <earpoint/error.h>
#include <earpoint/vam/encoding.h>

namespace earpoint {
namespace {

VamWeights binaural(VamWeights weights, const std::string& where) {
  if (weights.description.audio_channels != 2) {
    throw InputError(where, "the network is not binaural");
  }
  return weights;
}

}  // namespace

VamSynthesizer::VamSynthesizer(VamWeights weights, const std::string& where, int threads)
    : network_(binaural(std::move(weights), where), threads) {}

WindowShape VamSynthesizer::window_shape(int /*source_rate_hz*/) const {
  const std::ptrdiff_t samples = network_.description().window_samples;
  return {.sample_rate_hz = network_.description().sample_rate_hz,
          .samples = samples,
          .overlap = samples / 4,
          .context = 0};
}

double VamSynthesizer::ambient_cutoff_hz() const {
  return network_.description().highpass_cutoff_hz.value_or(0.0);
}

void VamSynthesizer::observe(const Observation& observation) {
  EARPOINT_CHECK(observation.picture != nullptr);
  if (observation.picture != seen_) map_ = network_.image_map(*observation.picture);
  seen_ = observation.picture;
  sound_ = observation.sound;
}

Waveform VamSynthesizer::synthesize(const Pose& source_from_target) {
  Waveform result(2, sound_.samples(), sound_.sample_rate_hz());
  network_.synthesize(sound_.planar(), map_, vam_pose(source_from_target), result.planar());
  return result;
}

}  // namespace earpoint

#include <earpoint/synthesis/dsp_synthesizer.h>

#include <algorithm>
#include <cmath>

#include <earpoint/audio/convolution.h>
#include <earpoint/error.h>
#include <earpoint/spatial/speaker_direction.h>

namespace earpoint {
namespace {

constexpr double kHalfWindow_s = 0.05;

std::ptrdiff_t half_window(int sample_rate_hz) {
  return static_cast<std::ptrdiff_t>(std::lround(kHalfWindow_s * sample_rate_hz));
}

}  // namespace

DspSynthesizer::DspSynthesizer(std::optional<std::filesystem::path> hrtf, double horizontal_fov_rad)
    : hrtf_path_(std::move(hrtf)), horizontal_fov_rad_(horizontal_fov_rad) {
  // A missing or broken set is found before any work is done. Its rate does not matter yet.
  if (hrtf_path_) {
    (void)read_sofa(*hrtf_path_);
  } else {
    (void)default_hrtf_path();
  }
}

const HrtfSet& DspSynthesizer::hrtf(int sample_rate_hz) const {
  if (!hrtf_ || hrtf_->sample_rate_hz() != sample_rate_hz) {
    hrtf_ = hrtf_path_ ? HrtfSet::load(*hrtf_path_, sample_rate_hz) : HrtfSet::load(sample_rate_hz);
  }
  return *hrtf_;
}

WindowShape DspSynthesizer::window_shape(int source_rate_hz) const {
  // The filters' lengths depend on the rate alone, so any direction will do.
  const Spherical ahead{.distance_m = 1.0};
  const EarFilterMatrix filters = dsp_filters(hrtf(source_rate_hz), ahead, ahead);
  const auto taps = static_cast<std::ptrdiff_t>(filters.taps[0][0].size());
  const std::ptrdiff_t half = half_window(source_rate_hz);
  return {.sample_rate_hz = source_rate_hz, .samples = 2 * half, .overlap = half, .context = taps};
}

Vector3 DspSynthesizer::locate_speaker(const Observation& observation) const {
  if (observation.speaker_m) return *observation.speaker_m;
  if (!observation.speaker_box) {
    throw InputError("dsp", "needs the direction of the speaker",
                     "give the speaker's position, or a picture and the speaker's box");
  }
  if (observation.picture == nullptr) {
    throw InputError("the speaker's box", "cannot be used without a picture",
                     "give the picture too, or the speaker's position");
  }
  return cartesian_from_spherical(
      speaker_direction_from_box(*observation.speaker_box, horizontal_fov_rad_,
                                 observation.picture->width(), observation.picture->height()));
}

void DspSynthesizer::observe(const Observation& observation) {
  speaker_m_ = locate_speaker(observation);
  sound_ = observation.sound;
}

Waveform DspSynthesizer::synthesize(const Pose& source_from_target) {
  const int rate = sound_.sample_rate_hz();
  const std::ptrdiff_t samples = 2 * half_window(rate);
  const std::ptrdiff_t context = (sound_.samples() - samples) / 2;
  const EarFilterMatrix filters = dsp_filters(hrtf(rate), speaker_m_, source_from_target);

  Waveform result(2, samples, rate);
  for (int ear = 0; ear < 2; ++ear) {
    const auto output = result.channel(ear);
    for (int source_ear = 0; source_ear < 2; ++source_ear) {
      const std::vector<float> filtered =
          convolve(sound_.channel(source_ear), filters.taps[ear][source_ear]);
      const auto first = filtered.begin() + context + filters.delay_samples;
      std::transform(output.begin(), output.end(), first, output.begin(), std::plus<>());
    }
  }
  return result;
}

}  // namespace earpoint

#include <earpoint/dataset/replay_pair.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/gcc_phat.h>
#include <earpoint/audio/window_of.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kMetresPerCentimetre = 0.01;
/// Sound travels 10 m in this time. At 16 kHz.
constexpr double kLongestWaySamples = 480.0;

Image image_of(const ImagePlanes& planes) {
  Image image(planes.width, planes.height, planes.channels);
  std::size_t i = 0;
  for (int channel = 0; channel < planes.channels; ++channel) {
    for (int y = 0; y < planes.height; ++y) {
      for (int x = 0; x < planes.width; ++x) {
        const float value = std::clamp(255.0F * planes.values[i++], 0.0F, 255.0F);
        image.at(x, y, channel) = static_cast<std::uint8_t>(std::lround(value));
      }
    }
  }
  return image;
}

}  // namespace

Pose world_from_camera(const ReplayCamera& camera) {
  const Vector3 centre_m = camera.centre * kMetresPerCentimetre;
  return look_at(centre_m, centre_m + camera.direction);
}

PairSample replay_pair(const ReplayDataset& dataset, const ReplayClip& clip,
                       const ReplayChoice& choice, bool align) {
  NvasSample loaded = dataset.sample(clip, choice, align);
  PairSample sample;
  sample.world_from_source =
      world_from_camera(dataset.camera(clip.scene, clip.images[choice.source]));
  const Pose world_from_target =
      world_from_camera(dataset.camera(clip.scene, clip.images[choice.target]));
  sample.source_from_target = inverse(sample.world_from_source) * world_from_target;
  sample.picture = std::make_shared<const Image>(image_of(loaded.source_rgb));
  const std::vector<double>& box = loaded.bboxes;
  // Four zeros say that the speaker is out of sight.
  if (std::ranges::any_of(box, [](double x) { return x != 0.0; })) {
    sample.speaker_box = Box{.x_min = box[0], .y_min = box[1], .x_max = box[2], .y_max = box[3]};
  }
  if (clip.mouth_m) {
    sample.speaker_m = transform_point(inverse(sample.world_from_source), *clip.mouth_m);
  }
  sample.source = std::move(loaded.source);
  sample.target = std::move(loaded.target);
  return sample;
}

Waveform near_voice(const ReplayDataset& dataset, const ReplayClip& clip, const Waveform& source) {
  const std::optional<Waveform> near = dataset.near_sound(clip);
  if (!near) {
    throw InputError(clip.folder, "has no near.wav, which is the dry speech",
                     "prepare it from a session with near microphones");
  }
  const double near_energy = energy(near->channel(0));
  const double source_energy = 0.5 * energy(source.planar());
  if (near_energy <= 0.0 || source_energy <= 0.0) {
    return {1, source.samples(), source.sample_rate_hz()};
  }
  const auto later = static_cast<int>(std::lround(
      gcc_phat_delay_samples(mean_of_channels(source), near->channel(0), kLongestWaySamples)));
  const auto gain = static_cast<float>(std::sqrt(source_energy / near_energy));
  Waveform voice = shifted(window_of(*near, 0, source.samples()), later);
  for (float& sample : voice.planar()) sample *= gain;
  return voice;
}

}  // namespace earpoint

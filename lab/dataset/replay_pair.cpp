#include <earpoint/dataset/replay_pair.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace earpoint {
namespace {

constexpr double kMetresPerCentimetre = 0.01;

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

}  // namespace earpoint

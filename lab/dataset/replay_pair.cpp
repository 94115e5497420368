#include <earpoint/dataset/replay_pair.h>

#include "byte_cache.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

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

std::string key_of(const char* what, const ReplayClip& clip, int view) {
  return what + clip.folder + "/" + clip.images.at(static_cast<std::size_t>(view));
}

std::optional<double> field_of_view(const ReplayClip& clip, int view) {
  if (clip.fov_rad.empty()) return std::nullopt;
  return clip.fov_rad.at(static_cast<std::size_t>(view));
}

}  // namespace

/// What it keeps of a camera's view.
struct ReplaySampler::View {
  std::shared_ptr<const Image> picture;
  Waveform sound;
};

ReplaySampler::ReplaySampler(const ReplayDataset& dataset, std::size_t cache_bytes)
    : dataset_(&dataset), cache_(std::make_unique<ByteCache>(cache_bytes)) {}
ReplaySampler::~ReplaySampler() = default;
ReplaySampler::ReplaySampler(ReplaySampler&&) noexcept = default;
ReplaySampler& ReplaySampler::operator=(ReplaySampler&&) noexcept = default;

Pose world_from_camera(const ReplayCamera& camera) {
  const Vector3 centre_m = camera.centre * kMetresPerCentimetre;
  return look_at(centre_m, centre_m + camera.direction);
}

PairSample ReplaySampler::source_sample(const ReplayClip& clip, int index) const {
  const std::shared_ptr<const View> source = view(clip, index);
  PairSample sample;
  sample.world_from_source = world_from_camera(
      dataset_->camera(clip.scene, clip.images.at(static_cast<std::size_t>(index))));
  sample.picture = source->picture;
  if (const auto fov_rad = field_of_view(clip, index)) sample.horizontal_fov_rad = *fov_rad;
  const std::vector<double> box = speaker_box(clip, index);
  // Four zeros say that the speaker is out of sight.
  if (std::ranges::any_of(box, [](double x) { return x != 0.0; })) {
    sample.speaker_box = Box{.x_min = box[0], .y_min = box[1], .x_max = box[2], .y_max = box[3]};
  }
  if (clip.mouth_m) {
    sample.speaker_m = transform_point(inverse(sample.world_from_source), *clip.mouth_m);
  }
  sample.source = window_of(source->sound, 0, kPairSamples);
  return sample;
}

PairSample ReplaySampler::sample(const ReplayClip& clip, const ReplayChoice& choice,
                                 bool align) const {
  PairSample sample = source_sample(clip, choice.source);
  const std::shared_ptr<const View> target = view(clip, choice.target);
  const Pose world_from_target = world_from_camera(
      dataset_->camera(clip.scene, clip.images.at(static_cast<std::size_t>(choice.target))));
  sample.source_from_target = inverse(sample.world_from_source) * world_from_target;
  sample.target = window_of(target->sound, 0, kPairSamples);
  if (align) {
    const Waveform moved = aligned_source(view(clip, choice.source)->sound, target->sound);
    sample.source = window_of(moved, 0, kPairSamples);
  }
  return sample;
}

PairSample ReplaySampler::enhancement_sample(const ReplayClip& clip, int view) const {
  PairSample sample = source_sample(clip, view);
  sample.dry = near_voice(clip, sample.source);
  sample.target =
      Waveform(sample.source.channels(), sample.dry.samples(), sample.dry.sample_rate_hz());
  for (int ear = 0; ear < sample.target.channels(); ++ear) {
    std::ranges::copy(sample.dry.channel(0), sample.target.channel(ear).begin());
  }
  return sample;
}

std::shared_ptr<const ReplaySampler::View> ReplaySampler::view(const ReplayClip& clip,
                                                               int index) const {
  return cache_->get<View>(
      key_of("view ", clip, index),
      [&] {
        ReplayView read = dataset_->view(clip, index);
        return View{std::make_shared<const Image>(image_of(read.rgb)), std::move(read.sound)};
      },
      [](const View& view) {
        return view.picture->pixels().size_bytes() + view.sound.planar().size_bytes();
      });
}

std::vector<double> ReplaySampler::speaker_box(const ReplayClip& clip, int index) const {
  using Numbers = std::vector<double>;
  return *cache_->get<Numbers>(
      key_of("box ", clip, index), [&] { return dataset_->box(clip, index); },
      [](const Numbers& box) { return box.size() * sizeof(double); });
}

Waveform ReplaySampler::near_voice(const ReplayClip& clip, const Waveform& source) const {
  const auto near = cache_->get<Waveform>(
      "near " + clip.folder,
      [&] {
        std::optional<Waveform> recorded = dataset_->near_sound(clip);
        if (recorded) return std::move(*recorded);
        throw InputError(clip.folder, "has no near.wav, which is the dry speech",
                         "prepare it from a session with near microphones");
      },
      [](const Waveform& sound) { return sound.planar().size_bytes(); });
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

PairSample replay_pair(const ReplayDataset& dataset, const ReplayClip& clip,
                       const ReplayChoice& choice, bool align) {
  return ReplaySampler(dataset, 0).sample(clip, choice, align);
}

}  // namespace earpoint

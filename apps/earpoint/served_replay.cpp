#include "served_dataset.h"

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/media/image_file.h>
#include <earpoint/pose.h>
#include <earpoint/render/make_synthesizer.h>

namespace earpoint {
namespace {

/// Sound, picture and speaker of the source.
void describe_source(const ReplayClip& clip, PairSample sample, ServedClip& served) {
  served.sound = std::move(sample.source);
  served.horizontal_fov_rad = sample.horizontal_fov_rad;
  served.picture = sample.picture;
  served.speaker_box = sample.speaker_box;
  if (!clip.mouth_m) return;
  served.speaker_m = sample.speaker_m;
  // The speaker's heading is not known: they are assumed to face the camera.
  served.speaker =
      ServedSpeaker{.position_m = sample.speaker_m,
                    .heading_rad = std::atan2(-sample.speaker_m.y, -sample.speaker_m.x),
                    .is_told = true};
}

ServedClip open_clip(const ReplayDataset& data, const ReplayClip& clip, int source) {
  ServedClip served;
  served.name = fmt::format("{}: camera {}", name_of(clip), camera_of(clip, source));
  for (int target = 0; target < std::ssize(clip.images); ++target) {
    if (target == source) continue;
    PairSample sample = replay_pair(data, clip, {source, target}, false);
    served.places.push_back(
        {"camera " + camera_of(clip, target), sample.source_from_target, std::move(sample.target)});
    if (served.places.size() == 1) describe_source(clip, std::move(sample), served);
  }
  if (served.speaker_box) served.people = {{*served.speaker_box, true}};
  if (served.picture) served.picture_png = encode_png(*served.picture);
  if (clip.fov_rad.empty() || !clip.fov_rad.at(static_cast<std::size_t>(source))) {
    served.warnings.push_back(fmt::format("field of view: {:.0f} degrees assumed",
                                          degrees_from_radians(served.horizontal_fov_rad)));
  }
  return served;
}

}  // namespace

void add_replay_dataset(const std::filesystem::path& folder, const std::string& split,
                        ClipLibrary& library) {
  const auto data = std::make_shared<const ReplayDataset>(replay_options(folder, split));
  const std::vector<ReplayChoice> choices = data->released_choices();
  std::size_t number = 0;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    const ReplayClip& clip = data->clips()[i];
    const int source = choices[i].source;
    if (clip.images.size() < 2) continue;
    library.add(fmt::format("r{}", number++),
                fmt::format("{}: camera {}", name_of(clip), camera_of(clip, source)),
                [data, &clip, source] { return open_clip(*data, clip, source); });
  }
}

}  // namespace earpoint

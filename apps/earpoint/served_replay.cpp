#include "served_dataset.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/pose.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/numpy_random.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/media/image_file.h>
#include <earpoint/render/make_synthesizer.h>

namespace earpoint {
namespace {

constexpr std::uint32_t kReleasedSeed = 0;

/// "data/appen_dataset/v3/SC-1027/3" is called SC-1027/3.
std::string short_name(const ReplayClip& clip) {
  const std::filesystem::path folder = clip.folder;
  return fmt::format("{}/{}", clip.scene, folder.filename().string());
}

/// "3.png" is camera 3.
std::string camera_name(const ReplayClip& clip, int view) {
  return "camera " +
         std::filesystem::path(clip.images.at(static_cast<std::size_t>(view))).stem().string();
}

ServedClip open_clip(const ReplayDataset& data, const ReplayClip& clip, int source) {
  ServedClip served;
  served.name = fmt::format("{}: {}", short_name(clip), camera_name(clip, source));
  // As evaluate takes it: the layout tells no field of view.
  served.horizontal_fov_rad = SynthesizerOptions{}.horizontal_fov_rad;
  for (int target = 0; target < std::ssize(clip.images); ++target) {
    if (target == source) continue;
    PairSample sample = replay_pair(data, clip, {source, target}, false);
    served.places.push_back(
        {camera_name(clip, target), sample.source_from_target, std::move(sample.target)});
    if (served.places.size() > 1) continue;
    served.sound = std::move(sample.source);
    served.picture = sample.picture;
    served.speaker_box = sample.speaker_box;
    if (!clip.mouth_m) continue;
    served.speaker_m = sample.speaker_m;
    // Nothing tells where the speaker looks: to the camera, as people who are filmed do.
    served.speaker =
        ServedSpeaker{.position_m = sample.speaker_m,
                      .heading_rad = std::atan2(-sample.speaker_m.y, -sample.speaker_m.x),
                      .is_told = true};
  }
  if (served.speaker_box) served.people = {{*served.speaker_box, true}};
  if (served.picture) served.picture_png = encode_png(*served.picture);
  served.warnings.push_back(fmt::format("field of view: {:.0f} degrees assumed",
                                        degrees_from_radians(served.horizontal_fov_rad)));
  return served;
}

}  // namespace

void add_replay_dataset(const std::filesystem::path& folder, const std::string& split,
                        ClipLibrary& library) {
  const auto data = std::make_shared<const ReplayDataset>(replay_options(folder, split));
  NumpyRandom random(kReleasedSeed);
  std::size_t number = 0;
  for (const ReplayClip& clip : data->clips()) {
    const int source = data->draw(clip, random).source;
    if (clip.images.size() < 2) continue;
    library.add(fmt::format("r{}", number++),
                fmt::format("{}: {}", short_name(clip), camera_name(clip, source)),
                [data, &clip, source] { return open_clip(*data, clip, source); });
  }
}

}  // namespace earpoint

#include "served_dataset.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/scene/homes.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCacheBytes = std::size_t{64} << 20U;
constexpr double kFovDegrees = 90.0;  // of the cameras of this layout

/// The data set, and what its clips are made with.
struct OpenDataset {
  explicit OpenDataset(const SoundSpacesDataset::Options& options)
      : dataset(options), sampler(dataset, kCacheBytes) {}
  SoundSpacesDataset dataset;
  PairSampler sampler;
  std::optional<std::uint64_t> home_seed;  ///< of simulated homes
};

/// The seed of the homes in a data set of `earpoint simulate`.
std::optional<std::uint64_t> home_seed_of(const fs::path& folder) {
  const fs::path record = folder / "dataset.json";
  if (!fs::exists(record)) return std::nullopt;
  const auto json = nlohmann::json::parse(read_text_file(record), nullptr, false);
  if (!json.is_object() || !json.contains("seed") || !json["seed"].is_number_unsigned()) {
    return std::nullopt;
  }
  const bool is_homes = json.contains("scene_source") && json["scene_source"].is_string() &&
                        json["scene_source"].get<std::string>().starts_with("homes ");
  if (!is_homes) return std::nullopt;
  return json["seed"].get<std::uint64_t>();
}

ServedPlan::Polygon polygon_of(const FloorRectangle& r, const Pose& source_from_world) {
  ServedPlan::Polygon polygon;
  for (const auto& [x, y] : {std::pair(r.x_min, r.y_min), std::pair(r.x_max, r.y_min),
                             std::pair(r.x_max, r.y_max), std::pair(r.x_min, r.y_max)}) {
    const Vector3 corner = transform_point(source_from_world, {x, y, 0.0});
    polygon.push_back({corner.x, corner.y});
  }
  return polygon;
}

/// The plan of a simulated home: it depends on the seed alone, not on the furniture.
std::optional<ServedPlan> plan_of(std::uint64_t dataset_seed, const std::string& scene,
                                  const Pose& world_from_source) {
  constexpr std::string_view kHome = "home-";
  std::uint64_t index = 0;
  if (!scene.starts_with(kHome)) return std::nullopt;
  const char* const end = scene.data() + scene.size();
  if (std::from_chars(scene.data() + kHome.size(), end, index).ptr != end) return std::nullopt;
  const std::uint64_t seed = RandomStream(dataset_seed, {index}).next();
  const FloorPlan plan = make_home(seed, {.furnishing = 0.0}, {}).plan;
  const Pose source_from_world = inverse(world_from_source);
  ServedPlan served;
  for (const Room& room : plan.rooms) {
    served.rooms.push_back(polygon_of(room.floor, source_from_world));
  }
  for (const Door& door : plan.doors) {
    if (door.state == DoorState::closed || door.room_b == Door::kOutside) continue;
    served.doors.push_back(polygon_of(door.opening, source_from_world));
  }
  return served;
}

std::vector<SeenPerson> people_of(const SoundSpacesClip& clip, const SoundSpacesChoice& choice) {
  const SoundSpacesViewpoint& view = clip.viewpoints.at(static_cast<std::size_t>(choice.source));
  std::vector<SeenPerson> people;
  for (std::size_t i = 0; i < clip.speakers.size(); ++i) {
    const auto box = view.bboxes.find(clip.speakers[i].id);
    if (box == view.bboxes.end()) continue;
    if (const auto seen = from_soundspaces_box(box->second)) {
      people.push_back({*seen, static_cast<int>(i) == choice.speaker});
    }
  }
  return people;
}

ServedClip open_clip(const OpenDataset& data, const SoundSpacesClip& clip, SoundSpacesChoice choice,
                     const std::string& name) {
  const auto& speaker = clip.speakers.at(static_cast<std::size_t>(choice.speaker));
  const std::ptrdiff_t samples = std::max(data.sampler.speech_samples(speaker), kPairSamples);
  choice.window_start = 0;
  ServedClip served;
  for (int target = 0; target < std::ssize(clip.viewpoints); ++target) {
    choice.target = target;
    PairSample sample = data.sampler.sample(clip, choice, samples);
    if (target == choice.source) continue;
    served.places.push_back(
        {fmt::format("viewpoint {}", target), sample.source_from_target, std::move(sample.target)});
    if (served.places.size() > 1) continue;
    served.sound = std::move(sample.source);
    served.picture = sample.picture;
    served.speaker_box = sample.speaker_box;
    served.speaker_m = sample.speaker_m;
    served.speaker = ServedSpeaker{.position_m = sample.speaker_m,
                                   .heading_rad = sample.speaker_yaw_rad.value_or(0.0),
                                   .is_told = true};
    if (data.home_seed) {
      served.plan = plan_of(*data.home_seed, clip.scene, sample.world_from_source);
    }
  }
  served.name = name;
  served.horizontal_fov_rad = radians_from_degrees(kFovDegrees);
  served.people = people_of(clip, choice);
  if (served.picture) served.picture_png = encode_png(*served.picture);
  return served;
}

}  // namespace

void add_dataset(const fs::path& folder, const std::string& split, ClipLibrary& library) {
  if (dataset_layout(folder, std::nullopt) == DatasetLayout::replay) {
    add_replay_dataset(folder, split, library);
    return;
  }
  const auto data = std::make_shared<OpenDataset>(soundspaces_options(folder, split));
  data->home_seed = home_seed_of(folder);
  std::map<std::array<int, 3>, int> known;
  std::map<std::string, int> scenes;
  for (const ViewPair& pair : frozen_or_drawn_pairs(data->dataset, folder).pairs) {
    const SoundSpacesClip& clip = clip_of(pair, data->dataset.clips(), folder.string());
    const int scene = scenes.try_emplace(pair.scene, static_cast<int>(scenes.size())).first->second;
    const SoundSpacesChoice& choice = pair.choice;
    if (clip.viewpoints.size() < 2) continue;
    const int view = choice.source * 1000 + choice.speaker;
    if (!known.try_emplace({scene, pair.clip, view}, 0).second) continue;
    const std::string id =
        fmt::format("s{}-{}-{}-{}", scene, pair.clip, choice.source, choice.speaker);
    const std::string name = fmt::format("{}, clip {}: viewpoint {}, speaker {}", pair.scene,
                                         pair.clip, choice.source, choice.speaker);
    library.add(id, name,
                [data, &clip, choice, name] { return open_clip(*data, clip, choice, name); });
  }
}

}  // namespace earpoint

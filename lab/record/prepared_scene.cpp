#include "prepared_scene.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kClip = "clip.json";
constexpr const char* kScene = "scene.json";
constexpr double kCentimetres = 100.0;

Json json_of(const Vector3& v) { return {v.x, v.y, v.z}; }

bool has_file(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  return !error && size > 0;
}

PreparedClip read_clip(const fs::path& path) {
  const nlohmann::json document = read_json(path);
  const JsonField json(document, path.string());
  PreparedClip clip;
  clip.window = json.field("window").integer();
  clip.time_s = json.field("time_s").number();
  clip.speaker = json.field("speaker").text();
  clip.overlapping = json.field("overlapping").integer() != 0;
  if (json.has("mouth_m")) clip.mouth_m = json.field("mouth_m").vector3();
  for (const JsonField& image : json.field("images").items()) clip.images.push_back(image.text());
  return clip;
}

void write_json(const fs::path& path, const Json& json) {
  write_file(path, std::string_view(json.dump(1) + "\n"));
}

}  // namespace

fs::path prepared_folder(const fs::path& out) { return out / ReplayDataset::Options{}.folder; }

std::string json_of(const PreparedClip& clip) {
  Json json{{"window", clip.window},
            {"time_s", clip.time_s},
            {"speaker", clip.speaker},
            {"overlapping", clip.overlapping ? 1 : 0}};
  if (clip.mouth_m) json["mouth_m"] = json_of(*clip.mouth_m);
  json["images"] = clip.images;
  return json.dump(1) + "\n";
}

std::optional<PreparedClip> stored_clip(const fs::path& folder) {
  if (!has_file(folder / kClip)) return std::nullopt;
  try {
    PreparedClip clip = read_clip(folder / kClip);
    for (const std::string& image : clip.images) {
      for (const char* extension : {".png", ".wav", ".npy"}) {
        if (!has_file(folder / fs::path(image).replace_extension(extension))) return std::nullopt;
      }
    }
    if (!has_file(folder / "near.wav")) return std::nullopt;
    return clip;
  } catch (const InputError&) {
    return std::nullopt;  // prepared again, as if it were missing
  }
}

void write_scene(const fs::path& folder, const std::string& split,
                 const std::vector<PreparedCamera>& cameras,
                 const std::vector<PreparedClip>& clips) {
  Json json;
  json["split"] = split;
  for (const PreparedCamera& camera : cameras) {
    const std::string name = fmt::format("DSLR-{}", camera.number);
    json["centers"][name] = json_of(camera.world_from_camera.position_m * kCentimetres);
    json["rotations"][name] = json_of(rotate(camera.world_from_camera.orientation, {1, 0, 0}));
  }
  const std::string scene = folder.filename().string();
  json["metadata"] = Json::object();
  json["clips"] = Json::object();
  for (const PreparedClip& clip : clips) {
    const std::string key =
        (ReplayDataset::Options{}.folder / scene / std::to_string(clip.window)).generic_string();
    json["metadata"][key] = clip.images;
    Json known{
        {"time_s", clip.time_s}, {"speaker", clip.speaker}, {"overlapping", clip.overlapping}};
    if (clip.mouth_m) known["mouth_m"] = json_of(*clip.mouth_m);
    for (const std::string& image : clip.images) {
      const auto camera =
          std::ranges::find(cameras, fs::path(image).stem().string(),
                            [](const PreparedCamera& c) { return std::to_string(c.number); });
      EARPOINT_CHECK(camera != cameras.end());
      const std::optional<double>& fov_rad = camera->horizontal_fov_rad;
      known["fov_deg"].push_back(fov_rad ? Json(degrees_from_radians(*fov_rad)) : Json());
    }
    json["clips"][key] = known;
  }
  write_json(folder / kScene, json);
}

void write_dataset_files(const fs::path& out) {
  const ReplayDataset::Options names;
  const fs::path folder = prepared_folder(out);
  std::vector<fs::path> scenes;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (has_file(entry.path() / kScene)) scenes.push_back(entry.path());
  }
  std::ranges::sort(scenes);
  Json metadata = Json::object();
  Json clips = Json::object();
  Json cameras{{"centers", Json::object()}, {"rotations", Json::object()}};
  Json splits{{"train", Json::array()}, {"val", Json::array()}, {"test", Json::array()}};
  for (const fs::path& scene : scenes) {
    const Json record = read_ordered_json(scene / kScene);
    const std::string name = scene.filename().string();
    try {
      splits.at(record.at("split").get<std::string>()).push_back(name);
      for (const char* key : {"centers", "rotations"}) cameras[key][name] = record.at(key);
      for (const auto& [key, value] : record.at("metadata").items()) metadata[key] = value;
      for (const auto& [key, value] : record.at("clips").items()) clips[key] = value;
    } catch (const nlohmann::json::exception& error) {
      throw InputError((scene / kScene).string(), error.what(), "prepare that session again");
    }
  }
  write_json(folder.parent_path() / names.camera_file, cameras);
  write_json(folder / names.splits_file, splits);
  write_json(folder / names.clips_file, clips);
  write_json(folder / names.metadata_file, metadata);
}

}  // namespace earpoint

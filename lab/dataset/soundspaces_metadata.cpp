#include <earpoint/dataset/soundspaces_metadata.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kImageSize = 256;

int parse_id(const std::string& key, const std::string& where) {
  int id = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), id);
  if (error != std::errc() || end != key.data() + key.size()) {
    throw InputError(where, "expected a speaker's number as key, found '" + key + "'");
  }
  return id;
}

SoundSpacesViewpoint parse_viewpoint(const JsonField& json) {
  SoundSpacesViewpoint viewpoint;
  viewpoint.location = json.field("location").vector3();
  viewpoint.rotation_rad = json.field("rotation").number();
  viewpoint.image = json.field("image").text();
  for (const auto& [key, value] : json.field("rir").fields()) {
    viewpoint.rir[parse_id(key, json.where())] = value.text();
  }
  for (const auto& [key, value] : json.field("bboxes").fields()) {
    const std::vector<JsonField> edges = value.items();
    if (edges.size() != 4) {
      throw InputError(value.where(), fmt::format("expected 4 numbers, found {}", edges.size()));
    }
    auto& box = viewpoint.bboxes[parse_id(key, json.where())];
    std::transform(edges.begin(), edges.end(), box.begin(),
                   [](const JsonField& edge) { return edge.integer(); });
  }
  return viewpoint;
}

SoundSpacesSpeaker parse_speaker(const JsonField& json) {
  SoundSpacesSpeaker speaker;
  speaker.id = json.field("id").integer();
  speaker.location = json.field("location").vector3();
  const JsonField speech = json.field("speech");
  if (!speech.is_null()) speaker.speech = speech.text();
  if (json.has("rotation")) speaker.rotation_rad = json.field("rotation").number();
  if (json.has("gender")) speaker.gender = json.field("gender").text();
  if (json.has("figure")) speaker.figure = json.field("figure").text();
  return speaker;
}

SoundSpacesClip parse_clip(const JsonField& json, const std::string& scene, int index) {
  SoundSpacesClip clip{scene, index, {}, {}};
  for (const JsonField& item : json.field("viewpoints").items()) {
    clip.viewpoints.push_back(parse_viewpoint(item));
  }
  for (const JsonField& item : json.field("speakers").items()) {
    clip.speakers.push_back(parse_speaker(item));
  }
  if (clip.viewpoints.size() < 2) throw InputError(json.where(), "fewer than two viewpoints");
  return clip;
}

nlohmann::ordered_json json_of(const Vector3& v) { return {v.x, v.y, v.z}; }

nlohmann::ordered_json json_of(const SoundSpacesViewpoint& viewpoint) {
  nlohmann::ordered_json json;
  json["location"] = json_of(viewpoint.location);
  json["rotation"] = viewpoint.rotation_rad;
  json["rir"] = nlohmann::ordered_json::object();
  for (const auto& [id, path] : viewpoint.rir) json["rir"][std::to_string(id)] = path;
  json["image"] = viewpoint.image;
  json["bboxes"] = nlohmann::ordered_json::object();
  for (const auto& [id, box] : viewpoint.bboxes) json["bboxes"][std::to_string(id)] = box;
  return json;
}

nlohmann::ordered_json json_of(const SoundSpacesSpeaker& speaker) {
  nlohmann::ordered_json json;
  json["id"] = speaker.id;
  json["speech"] = speaker.speech ? nlohmann::ordered_json(*speaker.speech) : nullptr;
  json["location"] = json_of(speaker.location);
  if (speaker.rotation_rad) json["rotation"] = *speaker.rotation_rad;
  if (speaker.gender) json["gender"] = *speaker.gender;
  if (speaker.figure) json["figure"] = *speaker.figure;
  return json;
}

}  // namespace

std::vector<SoundSpacesClip> parse_soundspaces_metadata(std::string_view json,
                                                        const std::string& where,
                                                        const std::string& scene) {
  const nlohmann::json document = parse_json(json, where);
  std::vector<SoundSpacesClip> clips;
  for (const JsonField& item : JsonField(document, where).items()) {
    clips.push_back(parse_clip(item, scene, static_cast<int>(clips.size())));
  }
  return clips;
}

std::string soundspaces_metadata(std::span<const SoundSpacesClip> clips) {
  nlohmann::ordered_json document = nlohmann::ordered_json::array();
  for (const SoundSpacesClip& clip : clips) {
    nlohmann::ordered_json item;
    item["viewpoints"] = nlohmann::ordered_json::array();
    for (const SoundSpacesViewpoint& v : clip.viewpoints) item["viewpoints"].push_back(json_of(v));
    item["speakers"] = nlohmann::ordered_json::array();
    for (const SoundSpacesSpeaker& s : clip.speakers) item["speakers"].push_back(json_of(s));
    document.push_back(std::move(item));
  }
  return document.dump(1) + "\n";
}

std::filesystem::path soundspaces_speech_file(std::string_view split, const std::string& speech) {
  const std::string part = split == "train"           ? "train-clean-360"
                           : split.starts_with("val") ? "dev-clean"
                                                      : "test-clean";
  const auto first = speech.find('-');
  const auto second = speech.find('-', first == std::string::npos ? first : first + 1);
  if (second == std::string::npos) {
    throw InputError("speech '" + speech + "'", "expected a name like book-chapter-section");
  }
  return std::filesystem::path(part) / speech.substr(0, first) /
         speech.substr(first + 1, second - first - 1) / (speech + ".flac");
}

Vector3 from_soundspaces(const Vector3& location) { return {-location.z, -location.x, location.y}; }

Vector3 to_soundspaces(const Vector3& position_m) {
  return {-position_m.y, position_m.z, -position_m.x};
}

double soundspaces_heading_rad(const Quaternion& orientation) {
  const double yaw_rad = euler_from_quaternion(orientation).yaw_rad;
  return yaw_rad < 0.0 ? yaw_rad + 2.0 * kPi : yaw_rad;
}

SoundSpacesBox soundspaces_box(const std::optional<Box>& box) {
  if (!box) return {};
  const auto first = [](double edge) { return static_cast<int>(std::floor(edge * kImageSize)); };
  const auto last = [](double edge) { return static_cast<int>(std::ceil(edge * kImageSize)) - 1; };
  return {first(box->y_min), last(box->y_max), first(box->x_min), last(box->x_max)};
}

std::optional<Box> from_soundspaces_box(const SoundSpacesBox& box) {
  if (box == SoundSpacesBox{}) return std::nullopt;
  constexpr double kSize = kImageSize;
  return Box{.x_min = box[2] / kSize,
             .y_min = box[0] / kSize,
             .x_max = (box[3] + 1) / kSize,
             .y_max = (box[1] + 1) / kSize};
}

}  // namespace earpoint

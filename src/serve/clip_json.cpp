#include "clip_json.h"

#include <nlohmann/json.hpp>

#include <earpoint/error.h>
#include <earpoint/synthesis/earpoint_path.h>

namespace earpoint {
namespace {

using nlohmann::json;

json json_of(const Vector3& p) { return {p.x, p.y, p.z}; }
json json_of(const Box& box) { return {box.x_min, box.y_min, box.x_max, box.y_max}; }

double yaw_deg_of(const Quaternion& orientation) {
  return degrees_from_radians(euler_from_quaternion(orientation).yaw_rad);
}

/// Why a method cannot be listened to; empty: it can.
std::string missing_for(const ListenMethod& method, const ServedClip& clip) {
  if (method.needs_box && (!clip.picture || !clip.speaker_box)) {
    return "it needs the speaker's box in the picture";
  }
  if (method.needs_speaker && !clip.speaker_m && !clip.speaker_box) {
    return "it needs the speaker's position, or the speaker's box in the picture";
  }
  return {};
}

json methods_of(const ServedClip& clip, std::span<const ListenMethod> methods) {
  json list = json::array();
  for (const ListenMethod& method : methods) {
    json entry{{"name", method.name}};
    const std::string missing = missing_for(method, clip);
    if (!missing.empty()) entry["missing"] = missing;
    if (method.model == "input") entry["browser"] = "recording";
    if (method.engine_model) entry["browser"] = "model";
    list.push_back(std::move(entry));
  }
  if (!clip.places.empty()) list.push_back({{"name", kTruthName}});
  return list;
}

json plan_of(const ServedPlan& plan) { return {{"rooms", plan.rooms}, {"doors", plan.doors}}; }

double number_of(const json& document, const char* key, double fallback) {
  const auto found = document.find(key);
  if (found == document.end()) return fallback;
  if (!found->is_number()) throw InputError(key, "is not a number");
  return found->get<double>();
}

Pose parse_pose(const json& document) {
  Pose pose;
  const json place = document.value("position_m", json::array({0, 0, 0}));
  if (!place.is_array() || place.size() != 3) throw InputError("position_m", "is not [x, y, z]");
  for (const json& coordinate : place) {
    if (!coordinate.is_number())
      throw InputError("position_m", "has an element that is not a number");
  }
  pose.position_m = {place[0].get<double>(), place[1].get<double>(), place[2].get<double>()};
  check_place(pose.position_m, "position_m");
  const double yaw_deg = number_of(document, "yaw_deg", 0.0);
  const double pitch_deg = number_of(document, "pitch_deg", 0.0);
  check_angle_deg(yaw_deg, "yaw_deg");
  check_angle_deg(pitch_deg, "pitch_deg");
  pose.orientation = quaternion_from_euler(
      {.yaw_rad = radians_from_degrees(yaw_deg), .pitch_rad = radians_from_degrees(pitch_deg)});
  return pose;
}

}  // namespace

json json_of(const ServedClip& clip, std::span<const ListenMethod> methods) {
  json document{{"name", clip.name},
                {"duration_s", clip.sound.duration_s()},
                {"sample_rate_hz", clip.sound.sample_rate_hz()},
                {"samples", clip.sound.samples()},
                {"has_picture", clip.picture != nullptr},
                {"fov_deg", degrees_from_radians(clip.horizontal_fov_rad)},
                {"methods", methods_of(clip, methods)},
                {"warnings", clip.warnings},
                {"people", json::array()},
                {"places", json::array()},
                {"has_movie", clip.source && clip.picture != nullptr && !clip.source->picture}};
  for (const SeenPerson& person : clip.people) {
    document["people"].push_back({{"box", json_of(person.box)}, {"speaks", person.speaks}});
  }
  for (const KnownPlace& place : clip.places) {
    document["places"].push_back({{"name", place.name},
                                  {"position_m", json_of(place.source_from_target.position_m)},
                                  {"yaw_deg", yaw_deg_of(place.source_from_target.orientation)}});
  }
  if (clip.speaker) {
    document["speaker"] = {{"position_m", json_of(clip.speaker->position_m)},
                           {"told", clip.speaker->is_told},
                           {"heading_deg", degrees_from_radians(clip.speaker->heading_rad)},
                           {"spread_deg", degrees_from_radians(clip.speaker->spread_rad)}};
  }
  // What a page's own engine is told, as the server's methods are.
  if (clip.speaker_box) document["speaker_box"] = json_of(*clip.speaker_box);
  if (clip.speaker_m) document["speaker_m"] = json_of(*clip.speaker_m);
  if (clip.map) {
    document["map"] = {{"camera_px", {clip.map->camera_x, clip.map->camera_y}},
                       {"pixels_per_metre", clip.map->pixels_per_metre}};
  }
  if (clip.plan) document["plan"] = plan_of(*clip.plan);
  return document;
}

std::string text_of(const json& document) {
  return document.dump(-1, ' ', false, json::error_handler_t::replace);
}

SoundRequest parse_sound_request(const std::string& body, const ServedClip& clip) {
  const json document = json::parse(body, nullptr, false);
  if (!document.is_object()) throw InputError("request", "is not a JSON object");
  SoundRequest request;
  const double start = number_of(document, "start", 0.0);
  const double samples = number_of(document, "samples", 0.0);
  if (!(start >= 0.0 && start < static_cast<double>(clip.sound.samples()))) {
    throw InputError("start", "is outside the clip");
  }
  if (!(samples >= 1.0 && samples <= clip.sound.sample_rate_hz())) {
    throw InputError("samples", "is not between 1 and a second's worth");
  }
  request.start = static_cast<std::ptrdiff_t>(start);
  request.samples = static_cast<std::ptrdiff_t>(samples);
  request.wish.source_from_target = parse_pose(document);
  if (const auto method = document.find("method"); method != document.end()) {
    if (!method->is_string()) throw InputError("method", "is not a string");
    request.wish.method = method->get<std::string>();
  }
  const auto matches = document.find("matches_level");
  request.wish.matches_level =
      matches != document.end() && matches->is_boolean() && matches->get<bool>();
  return request;
}

}  // namespace earpoint

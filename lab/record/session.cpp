#include <earpoint/record/session.h>

#include "calibration.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "earpoint-session-1";

/// The name of a camera or person, which appears in file names and tables.
std::string name_of(const JsonField& object, std::set<std::string>& taken) {
  const JsonField field = object.field("name");
  std::string name = field.text();
  const bool plain = !name.empty() && std::ranges::all_of(name, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || c == '.';
  });
  if (!plain || name.front() == '.') field.fail("a name of letters, digits, '-', '_' and '.'");
  if (!taken.insert(name).second) field.fail("a name that no other camera or person has");
  return name;
}

fs::path media_path(const JsonField& field, const fs::path& session_file) {
  const std::string path = field.text();
  if (path.empty()) field.fail("the path of a file");
  return session_file.parent_path() / path;
}

SessionCamera camera_of(const JsonField& json, const Session& session,
                        const CalibrationFrame& frame, std::set<std::string>& names) {
  json.expect_only({"name", "video", "intrinsics", "extrinsics"});
  SessionCamera camera;
  camera.name = name_of(json, names);
  camera.video = media_path(json.field("video"), session.file);
  if (json.has("intrinsics")) camera.lens = lens_of(json.field("intrinsics"));
  if (json.has("extrinsics")) camera.world_from_camera = pose_of(json.field("extrinsics"), frame);
  return camera;
}

/// @param microphone  of unknown wearer, if the session lists microphones separately
SessionPerson person_of(const JsonField& json, const Session& session,
                        const std::optional<fs::path>& microphone, std::set<std::string>& names) {
  json.expect_only({"name", "near", "near_distance_m"});
  SessionPerson person;
  person.name = name_of(json, names);
  if (microphone && json.has("near")) {
    json.field("near").fail("no file if the session lists its microphones separately");
  }
  person.near = microphone ? *microphone : media_path(json.field("near"), session.file);
  if (!json.has("near_distance_m")) return person;
  person.near_distance_m = json.field("near_distance_m").number();
  if (person.near_distance_m < 0.0) json.field("near_distance_m").fail("0 or more");
  return person;
}

void read_people(const JsonField& root, std::set<std::string>& names, Session& session) {
  const std::vector<JsonField> people =
      root.has("people") ? root.field("people").items() : std::vector<JsonField>{};
  session.wearers_known = !root.has("microphones");
  std::vector<fs::path> microphones;
  if (!session.wearers_known) {
    const JsonField field = root.field("microphones");
    for (const JsonField& item : field.items()) {
      microphones.push_back(media_path(item, session.file));
    }
    if (microphones.size() != people.size()) field.fail("as many files as there are people");
    if (!root.has("boxes")) {
      field.fail("boxes too, which show who wears which; or give every person's near");
    }
  }
  for (std::size_t p = 0; p < people.size(); ++p) {
    const auto microphone = session.wearers_known ? std::nullopt : std::optional(microphones[p]);
    session.people.push_back(person_of(people[p], session, microphone, names));
  }
}

void read_clap(const JsonField& root, const CalibrationFrame& frame, Session& session) {
  if (root.has("clap_s")) {
    session.clap_s = root.field("clap_s").number();
    if (*session.clap_s < 0.0) root.field("clap_s").fail("0 or more");
  }
  if (root.has("clap_position")) session.clap_m = position_of(root.field("clap_position"), frame);
}

/// The path as written in the session file.
std::string written_path(const fs::path& media, const fs::path& folder) {
  const fs::path relative = fs::absolute(media).lexically_normal().lexically_relative(
      fs::absolute(folder).lexically_normal());
  const bool below = !relative.empty() && *relative.begin() != "..";
  return below ? relative.generic_string() : media.generic_string();
}

nlohmann::ordered_json json_of(const Vector3& v) { return {v.x, v.y, v.z}; }

nlohmann::ordered_json json_of(const Lens& lens) {
  return {{"width", lens.width_px},
          {"height", lens.height_px},
          {"fx", lens.fx_px},
          {"fy", lens.fy_px},
          {"cx", lens.cx_px},
          {"cy", lens.cy_px},
          {"distortion", lens.distortion}};
}

nlohmann::ordered_json json_of(const Pose& pose) {
  const Vector3 x = rotate(pose.orientation, {1, 0, 0});
  const Vector3 y = rotate(pose.orientation, {0, 1, 0});
  const Vector3 z = rotate(pose.orientation, {0, 0, 1});
  nlohmann::ordered_json json;
  json["rotation"] = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
  json["translation"] = json_of(pose.position_m);
  return json;
}

}  // namespace

Session read_session(const fs::path& path) {
  const nlohmann::json document = read_json(path);
  const JsonField root(document, path.string());
  root.expect_only({"format", "scene", "split", "units", "frame", "up", "cameras", "calibration",
                    "people", "microphones", "boxes", "clap_s", "clap_position"});
  if (root.field("format").text() != kFormat) root.field("format").fail(kFormat);

  Session session;
  session.file = path;
  session.scene = root.has("scene") ? root.field("scene").text()
                                    : fs::absolute(path).parent_path().filename().string();
  if (session.scene.empty() || session.scene.find('/') != std::string::npos) {
    root.field("scene").fail("a valid folder name");
  }
  if (root.has("split")) {
    session.split = root.field("split").text();
    if (session.split != "train" && session.split != "val" && session.split != "test") {
      root.field("split").fail("train, val or test");
    }
  }
  const CalibrationFrame frame = calibration_frame(root);
  std::set<std::string> names;
  for (const JsonField& item : root.field("cameras").items()) {
    session.cameras.push_back(camera_of(item, session, frame, names));
  }
  if (session.cameras.size() < 2) root.field("cameras").fail("at least two cameras");
  read_people(root, names, session);
  if (root.has("boxes")) session.boxes = media_path(root.field("boxes"), path);
  read_clap(root, frame, session);
  if (root.has("calibration")) apply_calibration(root.field("calibration"), frame, session);
  return session;
}

void write_session(const fs::path& path, const Session& session) {
  const fs::path folder = path.parent_path();
  nlohmann::ordered_json json;
  json["format"] = kFormat;
  if (!session.scene.empty()) json["scene"] = session.scene;
  if (session.split) json["split"] = *session.split;
  json["units"] = "m";
  json["frame"] = "earpoint";
  json["cameras"] = nlohmann::ordered_json::array();
  for (const SessionCamera& camera : session.cameras) {
    nlohmann::ordered_json item{{"name", camera.name},
                                {"video", written_path(camera.video, folder)}};
    if (camera.lens) item["intrinsics"] = json_of(*camera.lens);
    if (camera.world_from_camera) item["extrinsics"] = json_of(*camera.world_from_camera);
    json["cameras"].push_back(item);
  }
  json["people"] = nlohmann::ordered_json::array();
  for (const SessionPerson& person : session.people) {
    nlohmann::ordered_json item{{"name", person.name}};
    if (session.wearers_known) item["near"] = written_path(person.near, folder);
    item["near_distance_m"] = person.near_distance_m;
    json["people"].push_back(item);
    if (!session.wearers_known) json["microphones"].push_back(written_path(person.near, folder));
  }
  if (session.boxes) json["boxes"] = written_path(*session.boxes, folder);
  if (session.clap_s) json["clap_s"] = *session.clap_s;
  if (session.clap_m) json["clap_position"] = json_of(*session.clap_m);
  write_file(path, std::string_view(json.dump(1) + "\n"));
}

}  // namespace earpoint

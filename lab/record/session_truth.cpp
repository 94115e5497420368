#include <earpoint/record/session_truth.h>

#include <array>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/csv.h>
#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "earpoint-session-truth-1";
constexpr double kPerMillion = 1e-6;
constexpr std::array<std::string_view, 9> kBoxColumns{
    "camera", "frame", "time_s", "person", "x_min", "y_min", "x_max", "y_max", "visible"};

std::vector<DeviceClock> clocks_of(const JsonField& list) {
  std::vector<DeviceClock> clocks;
  for (const JsonField& item : list.items()) {
    item.expect_only({"name", "offset_s", "drift_ppm"});
    clocks.push_back({item.field("name").text(), item.field("offset_s").number(),
                      item.field("drift_ppm").number()});
  }
  return clocks;
}

PersonTruth person_of(const JsonField& json) {
  json.expect_only({"name", "track", "speech"});
  PersonTruth person;
  person.name = json.field("name").text();
  for (const JsonField& item : json.field("track").items()) {
    item.expect_only({"time_s", "mouth_m", "yaw_deg"});
    const double time_s = item.field("time_s").number();
    if (!person.track.empty() && time_s <= person.track.back().time_s) {
      item.field("time_s").fail("a later time than before");
    }
    person.track.push_back({time_s, item.field("mouth_m").vector3(),
                            radians_from_degrees(item.field("yaw_deg").number())});
  }
  for (const JsonField& item : json.field("speech").items()) {
    const std::vector<JsonField> ends = item.items();
    if (ends.size() != 2) item.fail("[begin, end] in seconds");
    const SpeechInterval interval{ends[0].number(), ends[1].number()};
    const double earliest = person.speech.empty() ? interval.begin_s : person.speech.back().end_s;
    if (interval.begin_s < earliest || interval.end_s <= interval.begin_s) {
      item.fail("ascending intervals that do not overlap");
    }
    person.speech.push_back(interval);
  }
  return person;
}

nlohmann::ordered_json json_of(const std::vector<DeviceClock>& clocks) {
  auto list = nlohmann::ordered_json::array();
  for (const DeviceClock& clock : clocks) {
    list.push_back(
        {{"name", clock.name}, {"offset_s", clock.offset_s}, {"drift_ppm", clock.drift_ppm}});
  }
  return list;
}

nlohmann::ordered_json json_of(const PersonTruth& person) {
  nlohmann::ordered_json json{{"name", person.name}};
  json["track"] = nlohmann::ordered_json::array();
  for (const TrackPoint& point : person.track) {
    json["track"].push_back({{"time_s", point.time_s},
                             {"mouth_m", {point.mouth_m.x, point.mouth_m.y, point.mouth_m.z}},
                             {"yaw_deg", degrees_from_radians(point.yaw_rad)}});
  }
  json["speech"] = nlohmann::ordered_json::array();
  for (const SpeechInterval& interval : person.speech) {
    json["speech"].push_back({interval.begin_s, interval.end_s});
  }
  return json;
}

}  // namespace

double session_time_s(const DeviceClock& clock, double device_s) {
  return clock.offset_s + device_s / (1.0 + kPerMillion * clock.drift_ppm);
}

double device_time_s(const DeviceClock& clock, double session_s) {
  return (session_s - clock.offset_s) * (1.0 + kPerMillion * clock.drift_ppm);
}

SessionTruth read_session_truth(const fs::path& path) {
  const nlohmann::json document = read_json(path);
  const JsonField root(document, path.string());
  root.expect_only({"format", "cameras", "microphones", "people"});
  if (root.field("format").text() != kFormat) root.field("format").fail(kFormat);
  SessionTruth truth;
  truth.cameras = clocks_of(root.field("cameras"));
  truth.microphones = clocks_of(root.field("microphones"));
  for (const JsonField& item : root.field("people").items()) {
    truth.people.push_back(person_of(item));
  }
  return truth;
}

void write_session_truth(const fs::path& path, const SessionTruth& truth) {
  nlohmann::ordered_json json;
  json["format"] = kFormat;
  json["cameras"] = json_of(truth.cameras);
  json["microphones"] = json_of(truth.microphones);
  json["people"] = nlohmann::ordered_json::array();
  for (const PersonTruth& person : truth.people) json["people"].push_back(json_of(person));
  write_file(path, std::string_view(json.dump(1) + "\n"));
}

std::vector<PersonBox> read_person_boxes(const fs::path& path) {
  std::vector<PersonBox> boxes;
  for (const NumberRow& row : parse_number_csv(read_text_file(path), path.string(), kBoxColumns)) {
    const std::vector<double>& v = row.values;
    boxes.push_back({.camera = static_cast<int>(v[0]),
                     .frame = static_cast<int>(v[1]),
                     .time_s = v[2],
                     .person = static_cast<int>(v[3]),
                     .box = {.x_min = v[4], .y_min = v[5], .x_max = v[6], .y_max = v[7]},
                     .visible = v[8]});
  }
  return boxes;
}

void write_person_boxes(const fs::path& path, const std::vector<PersonBox>& boxes) {
  std::string text = "camera,frame,time_s,person,x_min,y_min,x_max,y_max,visible\n";
  for (const PersonBox& b : boxes) {
    text += fmt::format("{},{},{:.6f},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.4f}\n", b.camera, b.frame,
                        b.time_s, b.person, b.box.x_min, b.box.y_min, b.box.x_max, b.box.y_max,
                        b.visible);
  }
  write_file(path, std::string_view(text));
}

}  // namespace earpoint

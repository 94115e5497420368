#include <earpoint/record/sync_file.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>

namespace earpoint {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "earpoint-sync-1";
constexpr const char* kCamera = "camera";
constexpr const char* kMicrophone = "microphone";

Json json_of_device(const SyncedDevice& device) {
  Json json{{"name", device.clock.name},         {"kind", device.is_camera ? kCamera : kMicrophone},
            {"offset_s", device.clock.offset_s}, {"drift_ppm", device.clock.drift_ppm},
            {"duration_s", device.duration_s},   {"method", name_of(device.method)},
            {"windows", device.windows}};
  if (device.deviation_s) json["deviation_ms"] = 1e3 * *device.deviation_s;
  if (device.clap_s) json["clap_s"] = *device.clap_s;
  return json;
}

SyncMethod method_of(const JsonField& field) {
  const std::string name = field.text();
  for (const SyncMethod method :
       {SyncMethod::reference, SyncMethod::positions, SyncMethod::onsets}) {
    if (name == name_of(method)) return method;
  }
  field.fail("reference, positions or onsets");
}

SyncedDevice device_of(const JsonField& json) {
  json.expect_only({"name", "kind", "offset_s", "drift_ppm", "duration_s", "method", "windows",
                    "deviation_ms", "clap_s"});
  SyncedDevice device;
  device.clock = {json.field("name").text(), json.field("offset_s").number(),
                  json.field("drift_ppm").number()};
  const std::string kind = json.field("kind").text();
  if (kind != kCamera && kind != kMicrophone) json.field("kind").fail("camera or microphone");
  device.is_camera = kind == kCamera;
  device.duration_s = json.field("duration_s").number();
  device.method = method_of(json.field("method"));
  device.windows = json.field("windows").integer();
  if (json.has("deviation_ms")) device.deviation_s = 1e-3 * json.field("deviation_ms").number();
  if (json.has("clap_s")) device.clap_s = json.field("clap_s").number();
  return device;
}

LocatedVoice voice_of(const JsonField& json, const SyncResult& result) {
  json.expect_only({"time_s", "microphone", "mouth_m", "ears"});
  const std::string name = json.field("microphone").text();
  for (std::size_t d = 0; d < result.devices.size(); ++d) {
    if (result.devices[d].clock.name != name) continue;
    return {json.field("time_s").number(), d, json.field("mouth_m").vector3(),
            json.field("ears").integer()};
  }
  json.field("microphone").fail("the name of a device");
}

}  // namespace

std::string json_of(const SyncResult& result, const SyncErrors* errors) {
  Json json;
  json["format"] = kFormat;
  if (errors != nullptr) {
    json["offset_error_ms_p95"] = errors->offset_error_ms_p95;
    json["drift_error_ppm_p95"] = errors->drift_error_ppm_p95;
  }
  json["devices"] = Json::array();
  for (std::size_t d = 0; d < result.devices.size(); ++d) {
    Json device = json_of_device(result.devices[d]);
    if (errors != nullptr && d > 0) {
      device["offset_error_ms"] = errors->offset_errors_ms[d - 1];
      device["drift_error_ppm"] = errors->drift_errors_ppm[d - 1];
    }
    json["devices"].push_back(device);
  }
  json["voices"] = Json::array();
  for (const LocatedVoice& voice : result.voices) {
    const Vector3& mouth = voice.mouth_m;
    json["voices"].push_back({{"time_s", voice.time_s},
                              {"microphone", result.devices[voice.device].clock.name},
                              {"mouth_m", {mouth.x, mouth.y, mouth.z}},
                              {"ears", voice.ears}});
  }
  if (!result.wearers.empty()) json["wearers"] = Json::array();
  for (const MicrophoneWearer& wearer : result.wearers) {
    json["wearers"].push_back({{"microphone", wearer.microphone},
                               {"person", wearer.person},
                               {"certainty", wearer.certainty}});
  }
  json["notes"] = result.notes;
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

SyncResult read_sync(const std::filesystem::path& path) {
  const nlohmann::json document = read_json(path);
  const JsonField root(document, path.string());
  root.expect_only({"format", "devices", "voices", "wearers", "notes"});
  if (root.field("format").text() != kFormat) root.field("format").fail(kFormat);
  SyncResult result;
  for (const JsonField& item : root.field("devices").items()) {
    result.devices.push_back(device_of(item));
  }
  for (const JsonField& item : root.field("voices").items()) {
    result.voices.push_back(voice_of(item, result));
  }
  if (root.has("wearers")) {
    for (const JsonField& item : root.field("wearers").items()) {
      item.expect_only({"microphone", "person", "certainty"});
      result.wearers.push_back({item.field("microphone").text(), item.field("person").text(),
                                item.field("certainty").number()});
    }
  }
  for (const JsonField& item : root.field("notes").items()) result.notes.push_back(item.text());
  return result;
}

}  // namespace earpoint

#include "locate_report.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/error.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/network/model_names.h>
#include <earpoint/network/shipped_model.h>

namespace earpoint {
namespace {

constexpr const char* kShipped = "gtf.safetensors";

std::string model_of(const std::string& given) {
  if (!given.empty()) return resolve_model(given);
  if (const auto path = shipped_model_path(kShipped)) return path->string();
  throw InputError("locate", fmt::format("{} is not among the shipped models", kShipped),
                   "choose a gtf weight file with --model");
}

nlohmann::json json_of(const GtfSpeaker& speaker, bool is_3d) {
  const Vector3& p = speaker.position_m;
  nlohmann::json json{{"azimuth_deg", azimuth_deg(p)}};
  if (!is_3d) return json;
  json["elevation_deg"] = elevation_deg(p);
  json["distance_m"] = norm(p);
  json["position_m"] = {p.x, p.y, p.z};
  json["heading_deg"] = degrees_from_radians(speaker.yaw_rad);
  json["heading_certainty"] = speaker.yaw_certainty;
  return json;
}

nlohmann::json json_of(const PeopleFrame& frame) {
  nlohmann::json people = nlohmann::json::array();
  for (std::size_t i = 0; i < frame.people.size(); ++i) {
    const Box& box = frame.people[i].box;
    people.push_back({{"track", frame.people[i].track},
                      {"box", {box.x_min, box.y_min, box.x_max, box.y_max}},
                      {"seen", frame.people[i].is_seen},
                      {"speaking", frame.speaking(i)}});
  }
  return {{"time_s", frame.time_s},
          {"people", std::move(people)},
          {"outside", frame.belief.voice * frame.belief.outside},
          {"voice", frame.belief.voice}};
}

}  // namespace

double azimuth_deg(const Vector3& p) { return degrees_from_radians(std::atan2(p.y, p.x)); }

double elevation_deg(const Vector3& p) {
  return degrees_from_radians(std::atan2(p.z, std::hypot(p.x, p.y)));
}

LocateResult locate(const LocateRequest& request, ProgressSink& progress) {
  LocateResult result;
  result.model = model_of(request.model);
  result.source = parse_source(request.source);
  const GtfWeights weights = read_gtf_weights(result.model);
  if (!weights.description.geometry) {
    throw InputError(result.model, "cannot locate speakers: it has no geometry",
                     "choose another one with --model");
  }
  const double fov_rad =
      radians_from_degrees(fov_deg_of(request.source, result.source, !request.quiet));
  result.horizontal_fov_rad = fov_rad;
  SpeakerSearchResult search = search_speaker(request.source,
                                              {.horizontal_fov_rad = fov_rad,
                                               .detector = request.detector,
                                               .always_looks = true,
                                               .quiet = request.quiet},
                                              result.source, progress);
  result.people = std::move(*search.people);
  // Locate in the recording itself, without placing its voice.
  result.source.sound.placement = nullptr;
  result.speaker = locate_speaker(result.source, weights, fov_rad, progress);
  return result;
}

nlohmann::json json_of(const LocateResult& result, bool is_3d) {
  const LocatedSpeaker& located = result.speaker;
  nlohmann::json speaker = json_of(located.speaker, is_3d);
  speaker["azimuth_spread_deg"] = degrees_from_radians(located.azimuth_spread_rad);
  if (is_3d) speaker["distance_spread"] = std::expm1(located.log_distance_spread);
  nlohmann::json document{{"model", result.model},
                          {"by", nlohmann::json::array({"sound"})},
                          {"stereo", name_of(located.survey.stereo)},
                          {"warnings", located.survey.warnings},
                          {"speaker", speaker},
                          {"windows", nlohmann::json::array()},
                          {"detector", result.people.detector},
                          {"people", json_of(result.people)},
                          {"frames", nlohmann::json::array()}};
  for (const PeopleFrame& frame : result.people.frames) {
    document["frames"].push_back(json_of(frame));
  }
  if (located.has_picture) document["by"].push_back("picture");
  if (located.has_box) document["by"].push_back("box");
  for (const SpeakerSighting& sighting : located.sightings) {
    nlohmann::json window = json_of(sighting.speaker, is_3d);
    window["time_s"] = sighting.time_s;
    window["level_db"] = 20.0 * std::log10(sighting.level);
    document["windows"].push_back(std::move(window));
  }
  return document;
}

}  // namespace earpoint

#include "session_files.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool all_there(const std::vector<fs::path>& paths) {
  return std::all_of(paths.begin(), paths.end(),
                     [](const fs::path& path) { return fs::is_regular_file(path); });
}

Json record_of(const SessionSimulationOptions& options, const std::string& scene) {
  const SessionOptions& session = options.session;
  Json json;
  json["format"] = "earpoint-session-simulation-1";
  json["seed"] = options.seed;
  json["scenarios"] = options.scenarios;
  json["split"] = options.scenarios == 1 ? Json(name_of(options.split)) : Json();
  json["scene"] = scene;
  json["minutes"] = session.duration_s / 60.0;
  json["people"] = session.people ? Json(*session.people) : Json();
  json["cameras"] = session.cameras;
  json["walks_per_minute"] = session.walks_per_minute;
  json["drift_ppm"] = session.most_drift_ppm;
  json["offset_s"] = session.most_offset_s;
  json["snr_db"] = options.snr_db;
  json["frame_rate_hz"] = session.frame_rate_hz;
  json["image"] = {options.picture.width, options.picture.height};
  json["samples"] = options.picture.samples_per_side * options.picture.samples_per_side;
  json["horizontal_fov_deg"] = degrees_from_radians(options.picture.horizontal_fov_rad);
  json["rays"] = options.sound.rays;
  return json;
}

}  // namespace

SessionFiles::SessionFiles(fs::path session_folder, const SessionPlan& plan)
    : folder(std::move(session_folder)),
      session(folder / "session.json"),
      truth(folder / "truth.json"),
      boxes(folder / "boxes.csv"),
      sound_folder(folder / "sound-without-pictures") {
  for (std::size_t i = 1; i <= plan.world_from_camera.size(); ++i) {
    movies.push_back(folder / fmt::format("camera-{}.mp4", i));
    camera_sounds.push_back(sound_folder / fmt::format("camera-{}.w64", i));
  }
  for (std::size_t i = 1; i <= plan.people.size(); ++i) {
    microphones.push_back(folder / fmt::format("near-{}.wav", i));
  }
}

bool SessionFiles::has_all() const {
  return all_there({session, truth, boxes}) && all_there(movies) && all_there(microphones);
}

bool SessionFiles::has_sound() const { return all_there(camera_sounds) && all_there(microphones); }

void begin_simulation(const SessionSimulationOptions& options, const std::string& scene) {
  create_folder(options.folder);
  const fs::path path = options.folder / "simulation.json";
  const Json wanted = record_of(options, scene);
  if (!fs::exists(path)) {
    write_file(path, wanted.dump(2) + "\n");
    return;
  }
  const Json found = Json::parse(read_text_file(path), nullptr, false);
  if (found == wanted) return;
  std::string what = "it has other fields";
  for (const auto& [key, value] : wanted.items()) {
    if (found.is_object() && found.contains(key) && found[key] == value) continue;
    const std::string there =
        found.is_object() && found.contains(key) ? found[key].dump() : "missing";
    what = fmt::format("{} is {} there, {} here", key, there, value.dump());
    break;
  }
  throw InputError(path.string(), "was started with other options: " + what,
                   "use the same options, or another output folder");
}

Session describe_session(const SessionFiles& files, const SessionPlan& plan,
                         const SessionPictureQuality& picture, std::string name, DataSplit split) {
  Session session;
  session.file = files.session;
  session.scene = std::move(name);
  session.split = std::string(name_of(split));
  const Camera camera{.horizontal_fov_rad = picture.horizontal_fov_rad,
                      .width = picture.width,
                      .height = picture.height};
  const double focal_px = focal_length_pixels(camera);
  for (std::size_t i = 0; i < plan.world_from_camera.size(); ++i) {
    // OpenCV counts pixels from the middle of the first one.
    session.cameras.push_back({.name = plan.clocks[i].name,
                               .video = files.movies[i],
                               .lens = Lens{.width_px = picture.width,
                                            .height_px = picture.height,
                                            .fx_px = focal_px,
                                            .fy_px = focal_px,
                                            .cx_px = 0.5 * picture.width - 0.5,
                                            .cy_px = 0.5 * picture.height - 0.5,
                                            .distortion = {}},
                               .world_from_camera = plan.world_from_camera[i]});
  }
  for (std::size_t i = 0; i < plan.people.size(); ++i) {
    session.people.push_back({.name = plan.people[i].name,
                              .near = files.microphones[i],
                              .near_distance_m = norm(plan.people[i].microphone_m)});
  }
  session.boxes = files.boxes;
  session.clap_s = device_time_s(plan.clocks.front(), plan.clap_s);
  session.clap_m = plan.clap_m;
  return session;
}

SessionTruth truth_of(const SessionPlan& plan) {
  SessionTruth truth;
  const auto cameras = static_cast<std::ptrdiff_t>(plan.world_from_camera.size());
  truth.cameras.assign(plan.clocks.begin(), plan.clocks.begin() + cameras);
  truth.microphones.assign(plan.clocks.begin() + cameras, plan.clocks.end());
  for (std::size_t i = 0; i < plan.people.size(); ++i) {
    PersonTruth& person = truth.people.emplace_back();
    person.name = plan.people[i].name;
    person.track = track_of(plan.people[i], plan.duration_s);
    for (const Utterance& turn : plan.turns) {
      if (turn.person != static_cast<int>(i)) continue;
      const std::vector<SpeechInterval> intervals = speech_intervals(turn);
      person.speech.insert(person.speech.end(), intervals.begin(), intervals.end());
    }
  }
  return truth;
}

}  // namespace earpoint

#include "locate_command.h"

#include "json_text.h"
#include "source_arguments.h"
#include "speaker_search.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/locate/plot_people.h>
#include <earpoint/media/image_file.h>
#include <earpoint/network/model_names.h>
#include <earpoint/network/shipped_model.h>
#include <earpoint/render_files/locate_speaker.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

constexpr const char* kShipped = "gtf.safetensors";

constexpr const char* kFooter = R"(
The direction is seen from the camera: azimuth to its left, elevation up, degrees. x points to the
front, y to the left, z up; metres.

People are detected in the picture and tracked, five times a second; the interaural time difference
tells which of them speaks, or that the speaker is not in the picture. If a box is given, people are not
detected.

Examples:
  # the direction of the speaker, by picture and sound
  earpoint locate clip.mp4

  # a table of people and of who speaks when; render reads it, corrected by hand or not
  earpoint locate clip.mp4 -o boxes.csv --plot people.mp4
  earpoint render clip.mp4 --speaker-boxes boxes.csv --translate 1,0,0 -o there.wav

  # position and heading of a speaker whose box is given; and a map
  earpoint locate frame.png sound.flac --speaker-box 0.4,0.3,0.6,0.9 --3d --plot map.png

  # by sound alone, as JSON
  earpoint locate sound.wav --3d --json

Spreads are over the seconds of the recording: they show how steady the estimate is, not how accurate.
Stereo that is not binaural (panned, two equal channels, one silent or inverted channel) gets a warning: it
carries no direction of the speaker, and the spread is large.)";

struct LocateArguments {
  SourceArguments source;
  std::string model;
  std::string output;
  std::string plot;
  std::string detector;  ///< empty: the shipped one
  bool is_3d = false;
  bool json = false;
  bool quiet = false;
};

std::string model_of(const LocateArguments& arguments) {
  if (!arguments.model.empty()) return resolve_model(arguments.model);
  if (const auto path = shipped_model_path(kShipped)) return path->string();
  throw InputError("locate", fmt::format("{} is not among the shipped models", kShipped),
                   "choose a gtf weight file with --model");
}

double azimuth_deg(const Vector3& p) { return degrees_from_radians(std::atan2(p.y, p.x)); }

double elevation_deg(const Vector3& p) {
  return degrees_from_radians(std::atan2(p.z, std::hypot(p.x, p.y)));
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

void print_json(const LocateArguments& arguments, const std::string& model,
                const PeopleInClip& people, const LocatedSpeaker& located) {
  nlohmann::json speaker = json_of(located.speaker, arguments.is_3d);
  speaker["azimuth_spread_deg"] = degrees_from_radians(located.azimuth_spread_rad);
  if (arguments.is_3d) speaker["distance_spread"] = std::expm1(located.log_distance_spread);
  nlohmann::json document{{"model", model},
                          {"by", nlohmann::json::array({"sound"})},
                          {"stereo", name_of(located.survey.stereo)},
                          {"warnings", located.survey.warnings},
                          {"speaker", speaker},
                          {"windows", nlohmann::json::array()},
                          {"detector", people.detector},
                          {"people", earpoint::json_of(people)},
                          {"frames", nlohmann::json::array()}};
  for (const PeopleFrame& frame : people.frames) document["frames"].push_back(json_of(frame));
  if (located.has_picture) document["by"].push_back("picture");
  if (located.has_box) document["by"].push_back("box");
  for (const SpeakerSighting& sighting : located.sightings) {
    nlohmann::json window = json_of(sighting.speaker, arguments.is_3d);
    window["time_s"] = sighting.time_s;
    window["level_db"] = 20.0 * std::log10(sighting.level);
    document["windows"].push_back(std::move(window));
  }
  fmt::print("{}\n", json_text(document));
}

/// "12.3 degrees left"
std::string angle_text(double deg, const char* positive, const char* negative) {
  return fmt::format("{:.1f} degrees {}", std::abs(deg), deg < 0 ? negative : positive);
}

void print_people(const PeopleInClip& people) {
  const SpeakerSummary summary = summary_of(people);
  fmt::print("{:<10} {}  ({})\n", "people", summary.people, people.detector);
  if (people.frames.empty() || summary.people == 0) return;
  const std::string who =
      summary.speaker ? fmt::format("number {}", *summary.speaker) : "not in the picture";
  fmt::print("{:<10} {}  ({:.0f} % sure)\n", "speaker", who, 100.0 * summary.certainty);
}

void print_text(const LocateArguments& arguments, const LocatedSpeaker& located) {
  const Vector3& p = located.speaker.position_m;
  std::string direction = angle_text(azimuth_deg(p), "left", "right");
  if (arguments.is_3d) direction += ", " + angle_text(elevation_deg(p), "up", "down");
  fmt::print("{:<10} {}  (spread {:.1f} degrees over {} windows)\n", "direction", direction,
             degrees_from_radians(located.azimuth_spread_rad), located.sightings.size());
  if (arguments.is_3d) {
    fmt::print("{:<10} {:.2f} m  (spread {:.0f} %)\n", "distance", norm(p),
               100.0 * std::expm1(located.log_distance_spread));
    fmt::print("{:<10} {:.2f},{:.2f},{:.2f} m: front, left, up\n", "position", p.x, p.y, p.z);
    fmt::print("{:<10} {:.0f} degrees  (certainty {:.2f})\n", "heading",
               degrees_from_radians(located.speaker.yaw_rad), located.speaker.yaw_certainty);
  }
  fmt::print("{:<10} sound{}{}\n", "by", located.has_picture ? ", picture" : "",
             located.has_box ? ", box" : "");
}

bool is_movie_path(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return extension == ".mp4" || extension == ".m4v" || extension == ".mov";
}

void run_locate(const LocateArguments& arguments) {
  const std::string model = model_of(arguments);
  RenderInput source = parse_source(arguments.source);
  const GtfWeights weights = read_gtf_weights(model);
  if (!weights.description.geometry) {
    throw InputError(model, "cannot locate speakers: it has no geometry",
                     "choose another one with --model");
  }
  const bool plots_movie = is_movie_path(arguments.plot);
  if (!arguments.plot.empty() && !plots_movie) check_image_path(arguments.plot);
  const double fov_rad =
      radians_from_degrees(fov_deg_of(arguments.source, source, !arguments.quiet));
  SilentProgress silent;
  StreamProgress stream(stderr);
  ProgressSink& progress = arguments.quiet ? static_cast<ProgressSink&>(silent) : stream;
  const SpeakerSearchResult search = search_speaker(arguments.source,
                                                    {.horizontal_fov_rad = fov_rad,
                                                     .detector = arguments.detector,
                                                     .always_looks = true,
                                                     .quiet = arguments.quiet},
                                                    source, progress);
  // Locate in the recording itself, without placing its voice.
  source.sound.placement = nullptr;
  const LocatedSpeaker located = locate_speaker(source, weights, fov_rad, progress);
  print_warnings(arguments.source, located.survey);
  if (arguments.json) {
    print_json(arguments, model, *search.people, located);
  } else {
    print_text(arguments, located);
    print_people(*search.people);
  }
  if (!arguments.output.empty()) write_file(arguments.output, csv_of(*search.people));
  if (plots_movie) {
    write_people_movie(arguments.plot, source, *search.people, progress);
  } else if (!arguments.plot.empty()) {
    write_image(arguments.plot, plot_speaker(located, fov_rad));
  }
}

}  // namespace

void add_locate_command(CLI::App& app) {
  auto arguments = std::make_shared<LocateArguments>();
  CLI::App* command =
      app.add_subcommand("locate", "Find the speaker of a clip by picture, box and sound");
  command->footer(kFooter);
  add_source_inputs(*command, arguments->source);
  add_box_options(*command, arguments->source);
  command->add_option("--model", arguments->model, "A gtf weight file; default: the shipped one");
  add_detector_option(*command, arguments->detector);
  add_channel_option(*command, arguments->source);
  add_recording_option(*command, arguments->source);
  command->add_flag("--3d", arguments->is_3d, "Distance, height and heading as well");
  command->add_option(
      "-o,--output", arguments->output,
      "CSV of people's boxes and who speaks, five times a second; render reads it as "
      "--speaker-boxes");
  command->add_option(
      "--plot", arguments->plot,
      "Draw a map from above (.png), or a movie with everybody's box (.mp4 or .mov)");
  command->add_flag("--json", arguments->json, "Print JSON, with every window");
  command->add_flag("--quiet", arguments->quiet, "No progress");
  command->callback([arguments] { run_locate(*arguments); });
}

}  // namespace earpoint

#include "locate_command.h"

#include "json_text.h"
#include "locate_report.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/locate/plot_people.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

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
  LocateRequest request;
  std::string output;
  std::string plot;
  bool is_3d = false;
  bool json = false;
};

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
  const bool plots_movie = is_movie_path(arguments.plot);
  if (!arguments.plot.empty() && !plots_movie) check_image_path(arguments.plot);
  SilentProgress silent;
  StreamProgress stream(stderr);
  ProgressSink& progress = arguments.request.quiet ? static_cast<ProgressSink&>(silent) : stream;
  const LocateResult result = locate(arguments.request, progress);
  print_warnings(arguments.request.source, result.speaker.survey);
  if (arguments.json) {
    fmt::print("{}\n", json_text(json_of(result, arguments.is_3d)));
  } else {
    print_text(arguments, result.speaker);
    print_people(result.people);
  }
  if (!arguments.output.empty()) write_file(arguments.output, csv_of(result.people));
  if (plots_movie) {
    write_people_movie(arguments.plot, result.source, result.people, progress);
  } else if (!arguments.plot.empty()) {
    write_image(arguments.plot, plot_speaker(result.speaker, result.horizontal_fov_rad));
  }
}

}  // namespace

void add_locate_command(CLI::App& app) {
  auto arguments = std::make_shared<LocateArguments>();
  CLI::App* command =
      app.add_subcommand("locate", "Find the speaker of a clip by picture, box and sound");
  command->footer(kFooter);
  add_source_inputs(*command, arguments->request.source);
  add_box_options(*command, arguments->request.source);
  command->add_option("--model", arguments->request.model,
                      "A gtf weight file; default: the shipped one");
  add_detector_option(*command, arguments->request.detector);
  add_channel_option(*command, arguments->request.source);
  add_recording_option(*command, arguments->request.source);
  command->add_flag("--3d", arguments->is_3d, "Distance, height and heading as well");
  command->add_option(
      "-o,--output", arguments->output,
      "CSV of people's boxes and who speaks, five times a second; render reads it as "
      "--speaker-boxes");
  command->add_option(
      "--plot", arguments->plot,
      "Draw a map from above (.png), or a movie with everybody's box (.mp4 or .mov)");
  command->add_flag("--json", arguments->json, "Print JSON, with every window");
  command->add_flag("--quiet", arguments->request.quiet, "No progress");
  command->callback([arguments] { run_locate(*arguments); });
}

}  // namespace earpoint

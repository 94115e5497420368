#include "render_command.h"

#include "arguments.h"
#include "flag_advice.h"
#include "json_text.h"
#include "source_arguments.h"
#include "speaker_search.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/gtf/synthesizer.h>
#include <earpoint/media/image_file.h>
#include <earpoint/network/model_names.h>
#include <earpoint/plot/plot.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/render_files/render.h>

namespace earpoint {
namespace {

constexpr const char* kFooter = R"(
Frames: x points to the front of the source view, y to its left, z up; metres. A positive yaw turns
the target's head to the left, a positive pitch looks up.

If neither --speaker nor a box is given, and a people detector is installed, people are detected in the
picture, and the speaker among them is found by the interaural time difference; --json prints the
certainty. Without a detector gtf estimates the position. The voice of a recording that is not binaural
is first placed at the speaker's position.

Examples:
  # one metre ahead and half a metre to the right, looking left
  earpoint render clip.mp4 --translate 1.0,-0.5,0 --yaw 90 -o there.wav

  # the same, with the position of the mouth
  earpoint render clip.mp4 --translate 1.0,-0.5,0 --yaw 90 --speaker 2,0,0 -o there.wav

  # three earpoints in one pass, with a plot of both ears' waveforms
  earpoint render clip.mp4 --speaker 2,0,0 --plot ears.png \
      --translate 1,0,0 -o near.wav --translate -2,0,0 -o far.wav --translate 2,1,0 -o side.wav

  # a moving earpoint, with the clip's picture
  earpoint render clip.mp4 --path walk.csv --speaker-box 0.4,0.3,0.6,0.9 -o there.mp4

  # a picture and its sound, with ViGAS weights
  earpoint render frame.png sound.flac --model vigas.safetensors \
      --speaker-box 0.4,0.3,0.6,0.9 --translate 0,1,0 -o there.wav

A path is CSV with the header time_s,x,y,z,yaw_deg,pitch_deg,roll_deg. A file of boxes is CSV with
the header time_s,x0,y0,x1,y1. A pose file is JSON: {"position_m": [1, -0.5, 0], "yaw_deg": 90}.)";

struct RenderArguments {
  SourceArguments source;
  std::vector<std::string> outputs;
  std::vector<std::string> translations;
  std::vector<double> yaw_deg;
  std::vector<double> pitch_deg;
  std::vector<double> roll_deg;
  std::vector<std::string> pose_files;
  std::vector<std::string> path_files;
  std::string model;  ///< empty: the default
  std::string hrtf;
  std::string band = "full";
  std::string texture;  ///< empty: the model's
  std::string plot;
  std::string ambient = "bandpass";
  std::string detector;  ///< empty: the shipped one
  double ambient_cutoff_hz = -1.0;
  double gain_db = 0.0;
  int threads = available_cores();
  bool no_limit = false;
  bool json = false;
  bool quiet = false;
};

/// One angle for all targets, or one each.
double angle_of(const std::vector<double>& angles, std::size_t index, std::size_t count,
                const char* flag) {
  if (angles.empty()) return 0.0;
  for (const double angle_deg : angles) check_angle_deg(angle_deg, flag);
  if (angles.size() == 1) return radians_from_degrees(angles.front());
  if (angles.size() != count) {
    throw InputError(flag, fmt::format("given {} times for {} earpoints", angles.size(), count),
                     "give it once, or once for each --translate");
  }
  return radians_from_degrees(angles[index]);
}

std::vector<EarpointPath> parse_targets(const RenderArguments& arguments) {
  std::vector<EarpointPath> targets;
  std::vector<std::string> translations = arguments.translations;
  const bool turned =
      !arguments.yaw_deg.empty() || !arguments.pitch_deg.empty() || !arguments.roll_deg.empty();
  // Turning the head on the spot needs no --translate.
  if (turned && translations.empty()) {
    translations.resize(
        std::max({arguments.yaw_deg.size(), arguments.pitch_deg.size(), arguments.roll_deg.size()}),
        "0,0,0");
  }
  for (std::size_t i = 0; i < translations.size(); ++i) {
    const auto count = translations.size();
    targets.emplace_back(
        Pose{parse_place(translations[i], "--translate"),
             quaternion_from_euler({angle_of(arguments.yaw_deg, i, count, "--yaw"),
                                    angle_of(arguments.pitch_deg, i, count, "--pitch"),
                                    angle_of(arguments.roll_deg, i, count, "--roll")})});
  }
  for (const std::string& file : arguments.pose_files) {
    for (const Pose& pose : read_poses_json(file)) targets.emplace_back(pose);
  }
  for (const std::string& file : arguments.path_files) {
    targets.push_back(EarpointPath::from_csv(file));
  }
  if (targets.empty()) {
    throw InputError("render", "no earpoint given", "use --translate, --yaw, --to or --path");
  }
  if (targets.size() != arguments.outputs.size()) {
    throw InputError("-o", fmt::format("{} earpoints need as many outputs, {} given",
                                       targets.size(), arguments.outputs.size()));
  }
  return targets;
}

std::string describe(const WaveformOutline& outline) {
  return fmt::format("left {:.1f} dB, right {:.1f} dB, peak {:.2f}", outline.level_db(0),
                     outline.level_db(1), outline.peak());
}

nlohmann::json levels(const WaveformOutline& outline) {
  return {{"left_db", outline.level_db(0)},
          {"right_db", outline.level_db(1)},
          {"peak", outline.peak()}};
}

void print_json(const RenderArguments& arguments, const SpeakerSearchResult& search,
                const RenderReport& report) {
  std::vector<std::string> warnings = report.survey.warnings;
  warnings.insert(warnings.end(), report.warnings.begin(), report.warnings.end());
  nlohmann::json document{{"model", arguments.model},
                          {"duration_s", report.survey.duration_s()},
                          {"sample_rate_hz", report.survey.sample_rate_hz},
                          {"windows", report.windows},
                          {"source", levels(report.source)},
                          {"doubts", report.warnings},  // for one version more
                          {"stereo", name_of(report.survey.stereo)},
                          {"placed", search.is_placed},
                          {"warnings", warnings},
                          {"targets", nlohmann::json::array()}};
  if (search.people) document["people"] = json_of(*search.people);
  for (std::size_t i = 0; i < report.targets.size(); ++i) {
    nlohmann::json target = levels(report.targets[i]);
    target["output"] = arguments.outputs[i];
    target["limited_db"] = report.limited_db[i];
    document["targets"].push_back(std::move(target));
  }
  fmt::print("{}\n", json_text(document));
}

/// Whether sound goes to standard output, which then takes nothing else.
bool writes_to_stdout(const RenderArguments& arguments) {
  return std::ranges::find(arguments.outputs, "-") != arguments.outputs.end();
}

void print_table(const RenderArguments& arguments, const RenderReport& report) {
  std::FILE* const to = writes_to_stdout(arguments) ? stderr : stdout;
  fmt::print(to, "{:<24} {}\n", "source", describe(report.source));
  for (std::size_t i = 0; i < report.targets.size(); ++i) {
    fmt::print(to, "{:<24} {}\n", arguments.outputs[i], describe(report.targets[i]));
  }
}

void warn_of_model(const RenderArguments& arguments, const RenderReport& report) {
  for (const std::string& warning : report.warnings) {
    fmt::print(stderr, "earpoint: warning: {}: {}\n",
               std::filesystem::path(arguments.model).filename().string(), with_flags(warning));
  }
}

void warn_of_peaks(const RenderArguments& arguments, const RenderReport& report) {
  for (std::size_t i = 0; i < report.targets.size(); ++i) {
    const double limited_db = report.limited_db[i];
    const double excess_db = 20.0 * std::log10(std::max(report.targets[i].peak(), 1.0));
    if (limited_db > 0.0) {
      fmt::print(
          stderr,
          "earpoint: warning: {}: peaks {:.1f} dB above full scale were limited; --gain {:.0f} "
          "avoids it, --no-limit keeps them\n",
          arguments.outputs[i], limited_db, -std::ceil(limited_db));
    } else if (excess_db > 0.0) {
      fmt::print(
          stderr,
          "earpoint: warning: {}: peaks {:.1f} dB above full scale; --gain {:.0f} avoids it\n",
          arguments.outputs[i], excess_db, -std::ceil(excess_db));
    }
  }
}

/// Without the shipped models the result differs, so the user must know.
void warn_of_missing_network() {
  fmt::print(
      stderr,
      "earpoint: warning: gtf.safetensors is not among the shipped models, rendered by dsp; set "
      "EARPOINT_MODELS_DIR to its folder, or choose --model dsp\n");
}

void write_plot(const RenderArguments& arguments, const RenderReport& report) {
  const auto name_of = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  std::vector<WaveformPanel> panels = {
      {"source: " + name_of(arguments.source.inputs.back()), report.source}};
  for (std::size_t i = 0; i < report.targets.size(); ++i) {
    panels.push_back({name_of(arguments.outputs[i]), report.targets[i]});
  }
  write_image(arguments.plot, plot_waveforms(panels, "model: " + name_of(arguments.model)));
}

/// Whether a moment without a box means that the speaker is not in the picture.
bool is_gtf(const AcousticSynthesizer& synthesizer) {
  return dynamic_cast<const GtfSynthesizer*>(&synthesizer) != nullptr;
}

void run_render(RenderArguments arguments) {
  const bool takes_default = arguments.model.empty();
  arguments.model = resolve_model(arguments.model);
  if (arguments.json && writes_to_stdout(arguments)) {
    throw InputError("--json", "standard output is used for the sound already",
                     "write it to a file");
  }
  if (!arguments.hrtf.empty() && arguments.model != "dsp") {
    throw InputError("--hrtf", "only --model dsp uses head filters", "leave it out");
  }
  const std::vector<EarpointPath> paths = parse_targets(arguments);
  if (!arguments.plot.empty()) check_image_path(arguments.plot);
  RenderInput source = parse_source(arguments.source);
  std::vector<RenderTarget> targets;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    targets.push_back({paths[i], arguments.outputs[i]});
  }

  const bool uses_speaker = arguments.model != "input";
  const bool uses_fov =
      uses_speaker && (arguments.model != "dsp" || source.speaker_track || !source.speaker_m);
  SynthesizerOptions synthesizer_options;
  if (!arguments.hrtf.empty()) synthesizer_options.hrtf = arguments.hrtf;
  synthesizer_options.horizontal_fov_rad =
      radians_from_degrees(fov_deg_of(arguments.source, source, uses_fov && !arguments.quiet));
  synthesizer_options.threads = arguments.threads;
  synthesizer_options.texture = texture_of(arguments.texture);
  const auto synthesizer = make_synthesizer(arguments.model, synthesizer_options);

  ClipRenderOptions options;
  options.extend_band = arguments.band == "full";
  options.gain_db = arguments.gain_db;
  options.limit = !arguments.no_limit;
  options.threads = arguments.threads;
  options.ambient = *ambient_separation_named(arguments.ambient);
  if (arguments.ambient_cutoff_hz >= 0.0) options.ambient_cutoff_hz = arguments.ambient_cutoff_hz;

  SilentProgress silent;
  StreamProgress stream(stderr);
  ProgressSink& progress = arguments.quiet ? static_cast<ProgressSink&>(silent) : stream;
  SpeakerSearchResult search;
  if (uses_speaker) {
    search = search_speaker(arguments.source,
                            {.horizontal_fov_rad = synthesizer_options.horizontal_fov_rad,
                             .detector = arguments.detector,
                             .keeps_box = !is_gtf(*synthesizer),
                             .quiet = arguments.quiet},
                            source, progress);
    if (!arguments.quiet) tell_of_speaker(arguments.source, search, source);
  }
  const RenderReport report = render(source, *synthesizer, targets, options, progress);
  if (arguments.json) {
    print_json(arguments, search, report);
  } else if (!arguments.quiet) {
    print_table(arguments, report);
  }
  print_warnings(arguments.source, report.survey);
  if (takes_default && arguments.model == "dsp") warn_of_missing_network();
  warn_of_model(arguments, report);
  warn_of_peaks(arguments, report);
  if (!arguments.plot.empty()) write_plot(arguments, report);
}

void add_target_options(CLI::App& command, RenderArguments& arguments) {
  command
      .add_option(
          "-o,--output", arguments.outputs,
          "Output file: .wav .flac .ogg .mp3 .w64, or .mp4 .mov .mkv with the picture, or - for "
          "standard output (WAV); once per earpoint")
      ->required()
      ->allow_extra_args(false);
  const char* group = "Earpoints (all relative to the source view; repeat for several)";
  command.add_option("--translate", arguments.translations, "x,y,z in metres: front, left, up")
      ->allow_extra_args(false)
      ->group(group);
  command.add_option("--yaw", arguments.yaw_deg, "Degrees to the left")
      ->allow_extra_args(false)
      ->group(group);
  command.add_option("--pitch", arguments.pitch_deg, "Degrees up")
      ->allow_extra_args(false)
      ->group(group);
  command.add_option("--roll", arguments.roll_deg, "Degrees, towards the right shoulder")
      ->allow_extra_args(false)
      ->group(group);
  command.add_option("--to", arguments.pose_files, "JSON file with one pose or a list")
      ->allow_extra_args(false)
      ->group(group);
  command.add_option("--path", arguments.path_files, "CSV file with a moving earpoint")
      ->allow_extra_args(false)
      ->group(group);
}

void add_speaker_options(CLI::App& command, RenderArguments& arguments) {
  add_box_options(command, arguments.source);
  command
      .add_option("--speaker", arguments.source.speaker,
                  "x,y,z of the mouth in metres, instead of a box")
      ->group("Speaker");
  add_detector_option(command, arguments.detector);
}

void add_model_options(CLI::App& command, RenderArguments& arguments) {
  command.add_option(
      "--model", arguments.model,
      "input (copy), dsp (head filters), the name of a shipped model, or a weight file; "
      "default: gtf, or dsp where gtf is not installed");
  command
      .add_option(
          "--texture", arguments.texture,
          "For gtf networks trained for both: natural, with realistic modulation and decay; mean, "
          "with the smallest error of magnitudes; or a number from 0, the mean, to 1, natural; "
          "default: natural")
      ->check(known_texture());
  command.add_option("--hrtf", arguments.hrtf, "Head filters for dsp: a SOFA file");
  command
      .add_option("--band", arguments.band,
                  "full: sound above the model's band gets the gain of the band's top octave; "
                  "model: remove it")
      ->check(CLI::IsMember({"full", "model"}))
      ->capture_default_str();
  add_ambient_option(command, arguments.ambient, "which passes unchanged", "--ambient-cutoff");
  command
      .add_option("--ambient-cutoff", arguments.ambient_cutoff_hz,
                  "Sound below this (Hz) is ambient; default: the model's")
      ->check(within(0.0, 1000.0));
  add_channel_option(command, arguments.source);
  add_recording_option(command, arguments.source);
  command.add_option("--gain", arguments.gain_db, "Gain of the outputs in dB")
      ->check(within(-60.0, 60.0));
  command.add_flag("--no-limit", arguments.no_limit,
                   "Keep peaks above full scale; default: limit them");
  command.add_option("--threads", arguments.threads, "Number of threads; default: all cores")
      ->check(CLI::Range(1, 256));
}

}  // namespace

void add_render_command(CLI::App& app) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command = app.add_subcommand("render", "Hear a recorded clip from another earpoint");
  command->footer(kFooter);
  add_source_inputs(*command, arguments->source);
  add_target_options(*command, *arguments);
  add_speaker_options(*command, *arguments);
  add_model_options(*command, *arguments);
  command->add_option("--plot", arguments->plot, "Draw both ears of every earpoint into a PNG");
  command->add_flag("--json", arguments->json, "Print levels, warnings and who speaks as JSON");
  command->add_flag("--quiet", arguments->quiet, "No progress and no table");
  command->callback([arguments] { run_render(*arguments); });
}

}  // namespace earpoint

#include "enhance_command.h"

#include "arguments.h"
#include "json_text.h"
#include "source_arguments.h"

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
#include <earpoint/network/model_names.h>
#include <earpoint/network/shipped_model.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/render_files/render.h>

namespace earpoint {
namespace {

constexpr const char* kShipped = "enhance.safetensors";

constexpr const char* kFooter = R"(
The output is the dry speech in one channel, at its level 1 m in front of the mouth in free field.
Recordings above 16 kHz stay full-band: above 8 kHz the gain follows the top octave below. The output has
the recording's rate and length, without delay.

Examples:
  earpoint enhance clip.mp4 -o dry.wav

  # with the box of the speaker, where several people are in the picture
  earpoint enhance clip.mp4 --speaker-box 0.4,0.3,0.6,0.9 -o dry.flac

  # piped into another program
  earpoint enhance sound.wav -o - | ffmpeg -i - dry.mp3

  # with weights of your own (earpoint train configs/enhance.json)
  earpoint enhance clip.mp4 --model runs/enhance/best.safetensors -o dry.wav --json)";

struct EnhanceArguments {
  SourceArguments source;
  std::string output;
  std::string model;
  std::string ambient = "bandpass";
  std::string band = "full";
  double gain_db = 0.0;
  int threads = available_cores();
  bool no_limit = false;
  bool json = false;
  bool quiet = false;
};

std::string model_of(const EnhanceArguments& arguments) {
  if (!arguments.model.empty()) return resolve_model(arguments.model);
  if (const auto path = shipped_model_path(kShipped)) return path->string();
  throw InputError("enhance", fmt::format("{} is not among the shipped models", kShipped),
                   "choose a weight file trained for enhancement with --model");
}

/// What was assumed because it was not given: a line each.
std::vector<std::string> assumptions(const EnhanceArguments& arguments, const RenderInput& source,
                                     const RenderReport& report) {
  std::vector<std::string> lines;
  if (!source.speaker_track && !source.speaker_m) {
    lines.emplace_back("no speaker given: the loudest one is enhanced");
  }
  if (!report.has_picture) lines.emplace_back("no picture: the sound alone is used");
  if (report.survey.sample_rate_hz > report.model_rate_hz) {
    lines.push_back(
        arguments.band == "full"
            ? fmt::format("above {:g} kHz the gain follows the top octave below",
                          report.model_rate_hz / 2e3)
            : fmt::format("sound above {:g} kHz is dropped", report.model_rate_hz / 2e3));
  }
  if (arguments.ambient == "bandpass") {
    lines.emplace_back("ambient sound: below the model's cutoff");
  } else {
    lines.emplace_back("ambient sound: noise that is steady for a second");
  }
  return lines;
}

nlohmann::json levels(const WaveformOutline& outline, int channels) {
  nlohmann::json json{{"peak", outline.peak()}};
  if (channels == 1) {
    json["level_db"] = outline.level_db(0);
  } else {
    json["left_db"] = outline.level_db(0);
    json["right_db"] = outline.level_db(1);
  }
  return json;
}

void print_json(const EnhanceArguments& arguments, const std::string& model,
                const RenderInput& source, const RenderReport& report) {
  nlohmann::json output = levels(report.targets.front(), 1);
  output["file"] = arguments.output;
  output["limited_db"] = report.limited_db.front();
  const nlohmann::json document{{"model", model},
                                {"ambient", arguments.ambient},
                                {"duration_s", report.survey.duration_s()},
                                {"sample_rate_hz", report.survey.sample_rate_hz},
                                {"model_rate_hz", report.model_rate_hz},
                                {"stereo", name_of(report.survey.stereo)},
                                {"source", levels(report.source, 2)},
                                {"output", output},
                                {"assumed", assumptions(arguments, source, report)},
                                {"warnings", report.survey.warnings}};
  fmt::print("{}\n", json_text(document));
}

void run_enhance(const EnhanceArguments& arguments) {
  const bool to_stdout = arguments.output == "-";
  if (arguments.json && to_stdout) {
    throw InputError("--json", "standard output is used for the sound already",
                     "write it to a file");
  }
  const std::string model = model_of(arguments);
  const RenderInput source = parse_source(arguments.source);
  SynthesizerOptions synthesizer_options;
  synthesizer_options.horizontal_fov_rad =
      radians_from_degrees(fov_deg_of(arguments.source, source, !arguments.quiet));
  synthesizer_options.threads = arguments.threads;
  synthesizer_options.enhances = true;
  const auto synthesizer = make_synthesizer(model, synthesizer_options);

  ClipRenderOptions options;
  options.answer = RenderAnswer::voice;
  options.extend_band = arguments.band == "full";
  options.ambient = *ambient_separation_named(arguments.ambient);
  options.gain_db = arguments.gain_db;
  options.limit = !arguments.no_limit;
  options.threads = arguments.threads;

  SilentProgress silent;
  StreamProgress stream(stderr);
  ProgressSink& progress = arguments.quiet ? static_cast<ProgressSink&>(silent) : stream;
  // The target is the camera's own pose: the position of the microphone near the mouth is unknown
  // and not needed.
  const RenderTarget target{EarpointPath(Pose{}), arguments.output};
  const RenderReport report = render(source, *synthesizer, {&target, 1}, options, progress);
  if (arguments.json) {
    print_json(arguments, model, source, report);
  } else if (!arguments.quiet) {
    std::FILE* const to = to_stdout ? stderr : stdout;
    fmt::print(to, "{:<24} left {:.1f} dB, right {:.1f} dB\n", "recording",
               report.source.level_db(0), report.source.level_db(1));
    fmt::print(to, "{:<24} {:.1f} dB, peak {:.2f}\n", arguments.output,
               report.targets.front().level_db(0), report.targets.front().peak());
    for (const std::string& line : assumptions(arguments, source, report)) {
      fmt::print(to, "assumed: {}\n", line);
    }
  }
  print_warnings(arguments.source, report.survey);
  if (report.limited_db.front() > 0.0) {
    fmt::print(
        stderr,
        "earpoint: warning: {}: peaks {:.1f} dB above full scale were limited; --gain {:.0f} "
        "avoids it\n",
        arguments.output, report.limited_db.front(), -std::ceil(report.limited_db.front()));
  }
}

}  // namespace

void add_enhance_command(CLI::App& app) {
  auto arguments = std::make_shared<EnhanceArguments>();
  CLI::App* command = app.add_subcommand(
      "enhance", "The speaker's voice as a microphone close to the mouth would record it");
  command->footer(kFooter);
  add_source_inputs(*command, arguments->source);
  command
      ->add_option("-o,--output", arguments->output,
                   "Where the voice goes, one channel: .wav .flac .ogg .mp3 .w64, or - for "
                   "standard output (WAV)")
      ->required();
  add_box_options(*command, arguments->source);
  command
      ->add_option("--speaker", arguments->source.speaker,
                   "x,y,z of the mouth in metres, in place of a box")
      ->group("Who speaks");
  command->add_option("--model", arguments->model,
                      "A weight file that was trained for enhancement, or the name of a shipped "
                      "one; default: enhance");
  add_ambient_option(*command, arguments->ambient, "which is removed", "the model's cutoff");
  command
      ->add_option("--band", arguments->band,
                   "full: what lies above the model's band follows its top octave; model: leave "
                   "it out")
      ->check(CLI::IsMember({"full", "model"}))
      ->capture_default_str();
  add_channel_option(*command, arguments->source);
  command->add_option("--gain", arguments->gain_db, "Gain of the output in dB")
      ->check(within(-60.0, 60.0));
  command->add_flag("--no-limit", arguments->no_limit,
                    "Write peaks above full scale as they are; default: they are limited");
  command->add_option("--threads", arguments->threads, "Default: all cores")
      ->check(CLI::Range(1, 256));
  command->add_flag("--json", arguments->json, "Print levels and what was assumed as JSON");
  command->add_flag("--quiet", arguments->quiet, "No progress and no table");
  command->callback([arguments] { run_enhance(*arguments); });
}

}  // namespace earpoint

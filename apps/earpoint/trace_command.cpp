#include "trace_command.h"

#include "flag_checks.h"
#include "scene_argument.h"
#include "trace_arguments.h"
#include "trace_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/error.h>
#include <earpoint/spatial/air_absorption.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/response_end.h>
#include <earpoint/trace/response_renderer.h>
#include <earpoint/trace/tracer.h>

namespace {

namespace fs = std::filesystem;
using earpoint::InputError;

constexpr double kLongest_s = 30.0;

struct Options {
  SceneArgument scene;
  std::string source;
  std::string directivity = "omni";
  std::string listener;
  fs::path output;
  std::optional<fs::path> hrtf;
  std::optional<int> ambisonics;
  bool mono = false;
  bool report = false;
  int rate_hz = 16000;
  int jobs = 0;
  earpoint::TraceOptions trace;
};

void check(const Options& options) {
  const auto at_least = [](const char* flag, double value, double least) {
    if (value >= least) return;
    throw InputError(flag, fmt::format("expected {:g} or more, found {:g}", least, value));
  };
  const auto within = [](const char* flag, double value, double least, double most) {
    if (value >= least && value <= most) return;
    throw InputError(flag,
                     fmt::format("expected {:.10g} to {:.10g}, found {:.10g}", least, most, value));
  };
  within("--rays", options.trace.rays, 1, 100e6);
  at_least("--bounces", options.trace.max_bounces, 1);
  within("--rate", options.rate_hz, 8000, 192000);
  at_least("--jobs", options.jobs, 0);
  within("--duration", options.trace.duration_s, 0.01, kLongest_s);
  if (options.ambisonics) {
    if (*options.ambisonics < 1 || *options.ambisonics > 7) {
      throw InputError("--ambisonics",
                       fmt::format("expected an order of 1 to 7, found {}", *options.ambisonics));
    }
    if (options.mono || options.hrtf) {
      throw InputError("--ambisonics", "is another kind of microphone than --mono and --hrtf",
                       "give one of the three");
    }
  }
  if (options.mono && options.hrtf) {
    throw InputError("--mono", "a single microphone has no HRTF", "leave out --mono or --hrtf");
  }
}

// A place outside of the model hears nothing, whatever the mesh.
// @param place  in the user's coordinates
void check_place(const char* flag, const earpoint::Vector3& place, const NamedScene& named) {
  earpoint::Bounds box = bounds(named.scene.mesh);
  box = {box.low + named.origin_m, box.high + named.origin_m};
  const bool inside = place.x > box.low.x && place.x < box.high.x && place.y > box.low.y &&
                      place.y < box.high.y && place.z > box.low.z && place.z < box.high.z;
  if (inside) return;
  throw InputError(
      flag,
      fmt::format("({:.10g}, {:.10g}, {:.10g}) is outside of the scene, which spans x {:.9g} to "
                  "{:.9g}, y {:.9g} to {:.9g}, z {:.9g} to {:.9g} m",
                  place.x, place.y, place.z, box.low.x, box.high.x, box.low.y, box.high.y,
                  box.low.z, box.high.z),
      "place it inside");
}

// Sound takes its time: a response that ends before holds none.
void check_long_enough(const Options& options, double distance_m) {
  const double first_s = distance_m / earpoint::speed_of_sound_m_per_s(options.trace.air);
  if (options.trace.duration_s > first_s) return;
  throw InputError("--duration",
                   fmt::format("ends after {:g} s, before the sound arrives after {:.3f} s",
                               options.trace.duration_s, first_s),
                   fmt::format("use --duration {:.1f} or more", first_s + 0.1));
}

void warn_of_early_end(const earpoint::PointResponse& response, double duration_s) {
  const earpoint::ResponseEnd end = earpoint::response_end(response, duration_s);
  if (end.level_db <= -60.0 || duration_s >= kLongest_s) return;
  const double wanted_s = std::min(kLongest_s, std::ceil(10.0 * end.needed_s) / 10.0);
  fmt::print(stderr, "earpoint: warning: the response ends at {:.0f} dB; use {}\n", end.level_db,
             std::isfinite(end.needed_s) ? fmt::format("--duration {:g}", wanted_s)
                                         : "a longer --duration");
}

bool is_silent(const earpoint::PointResponse& response) {
  if (!response.arrivals.empty()) return false;
  for (int bin = 0; bin < response.late.bins(); ++bin) {
    for (const float energy : response.late.bin_energy(bin)) {
      if (energy > 0.0F) return false;
    }
  }
  return true;
}

// The ears, where there are any: read before anything is traced.
std::optional<earpoint::HrtfSet> load_ears(const Options& options) {
  if (options.mono || options.ambisonics) return std::nullopt;
  return options.hrtf ? earpoint::HrtfSet::load(*options.hrtf, options.rate_hz)
                      : earpoint::HrtfSet::load(options.rate_hz);
}

earpoint::Waveform render(const Options& options, const earpoint::ResponseRenderer& renderer,
                          const earpoint::PointResponse& response,
                          const earpoint::Quaternion& world_from_listener,
                          const std::optional<earpoint::HrtfSet>& ears) {
  if (options.ambisonics) {
    return renderer.ambisonic(response, world_from_listener, *options.ambisonics, 0);
  }
  return ears ? renderer.binaural(response, world_from_listener, *ears, 0)
              : renderer.mono(response, 0);
}

void run(const Options& options) {
  check(options);
  const auto start = std::chrono::steady_clock::now();
  earpoint::Source source{.world_from_source = parse_pose("--source", options.source)};
  if (options.directivity == "speech") source.directivity = earpoint::speech_directivity();
  earpoint::Pose listener = parse_pose("--listener", options.listener);
  earpoint::Vector3& source_m = source.world_from_source.position_m;
  const double distance_m = norm(listener.position_m - source_m);
  if (distance_m < 1e-3) {
    throw InputError("--listener", "stands where the source is", "move one of them");
  }
  const std::optional<earpoint::HrtfSet> ears = load_ears(options);
  const NamedScene named = read_scene(options.scene);
  for (const std::string& warning : named.warnings) {
    fmt::print(stderr, "earpoint: {}: {}\n", options.scene.file.string(), warning);
  }
  check_place("--source", source_m, named);
  check_place("--listener", listener.position_m, named);
  check_long_enough(options, distance_m);
  source_m = source_m - named.origin_m;
  listener.position_m = listener.position_m - named.origin_m;
  const earpoint::AcousticScene scene(named.scene);

  const int jobs = options.jobs > 0 ? options.jobs : earpoint::available_cores();
  earpoint::ThreadPool pool(jobs);
  const earpoint::TraceResult traced =
      earpoint::trace(scene, {&source, 1}, {&listener.position_m, 1}, options.trace, pool);
  const earpoint::PointResponse& response = traced.responses[0][0];
  if (is_silent(response)) {
    throw InputError("--listener", "no sound reaches it", "place it in the room of the source");
  }
  const earpoint::ResponseRenderer renderer({.sample_rate_hz = options.rate_hz,
                                             .duration_s = options.trace.duration_s,
                                             .seed = options.trace.seed});
  earpoint::write_sound(options.output,
                        render(options, renderer, response, listener.orientation, ears),
                        earpoint::SampleFormat::float32);
  warn_of_early_end(response, options.trace.duration_s);
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  if (options.report) {
    const earpoint::Waveform mono = renderer.mono(response, 0);
    fmt::print("{}", trace_report(traced, mono.channel(0), options.rate_hz, passed.count()));
  }
}

void add_physics(CLI::App& command, Options& options) {
  earpoint::TraceOptions& trace = options.trace;
  command.add_option("--rays", trace.rays, "Rays that leave the source")->capture_default_str();
  command.add_option("--bounces", trace.max_bounces, "Most reflections of a ray")
      ->capture_default_str();
  command.add_option("--duration", trace.duration_s, "Length of the response, seconds")
      ->capture_default_str();
  command.add_option("--seed", trace.seed, "The same seed gives the same response")
      ->check(whole_number())
      ->capture_default_str();
  command.add_option("--temperature", trace.air.temperature_celsius, "Of the air, degrees Celsius")
      ->capture_default_str();
  command
      .add_option("--humidity", trace.air.relative_humidity_percent,
                  "Relative humidity of the air, percent")
      ->capture_default_str();
  command.add_option("--jobs", options.jobs, "Threads; 0 takes all cores")->capture_default_str();
}

}  // namespace

void add_trace_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("trace",
                         "Trace sound through a scene: the impulse response from a source "
                         "to a listener's two ears.");
  add_scene_argument(*command, options->scene);
  command
      ->add_option("--source", options->source,
                   "Where the sound starts: X,Y,Z[,yaw=DEG][,pitch=DEG][,roll=DEG], metres, z up; "
                   "its level is that in front")
      ->required();
  command
      ->add_option("--directivity", options->directivity,
                   "How it spreads: omni, or speech, louder in front")
      ->check(CLI::IsMember({"omni", "speech"}))
      ->capture_default_str();
  command
      ->add_option(
          "--listener", options->listener,
          "Where it is heard: X,Y,Z[,yaw=DEG][,pitch=DEG][,roll=DEG]; yaw 0 looks along x, "
          "90 along y")
      ->required();
  command->add_option("-o,--output", options->output, "Sound file to write (.wav or .w64)")
      ->required();
  command->add_flag("--mono", options->mono, "One omnidirectional microphone instead of two ears");
  command->add_option("--ambisonics", options->ambisonics,
                      "An ambisonic microphone of this order, 1 to 7: channels as ACN, norm N3D");
  command->add_option("--rate", options->rate_hz, "Samples per second")->capture_default_str();
  command->add_option("--hrtf", options->hrtf, "Head-related responses (.sofa)");
  add_physics(*command, *options);
  command->add_flag("--report", options->report, "Print decay times, levels and cost");
  command->callback([options] { run(*options); });
}

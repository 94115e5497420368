#include "trace_command.h"

#include "flag_checks.h"
#include "scene_argument.h"
#include "trace_arguments.h"
#include "trace_motion_command.h"
#include "trace_report.h"
#include "trace_setup.h"

#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/error.h>
#include <earpoint/trace/response_synthesizer.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {
namespace {

void run_still(const TraceSetup& options) {
  const auto start = std::chrono::steady_clock::now();
  Source source = make_source(options);
  source.world_from_source = parse_pose("--source", options.source);
  Pose listener = parse_pose("--listener", options.listener);
  Vector3& source_m = source.world_from_source.position_m;
  const double distance_m = norm(listener.position_m - source_m);
  if (distance_m < 1e-3) {
    throw InputError("--listener", "is at the position of the source", "move one of them");
  }
  const std::optional<HrtfSet> ears = load_ears(options);
  const NamedScene named = read_scene_with_warnings(options.scene);
  check_place("--source", source_m, named);
  check_place("--listener", listener.position_m, named);
  check_long_enough(options, distance_m);
  source_m = source_m - named.origin_m;
  listener.position_m = listener.position_m - named.origin_m;
  const AcousticScene scene(named.scene);

  const int jobs = options.jobs > 0 ? options.jobs : available_cores();
  ThreadPool pool(jobs);
  const TraceResult traced =
      trace(scene, {&source, 1}, {&listener.position_m, 1}, options.trace, pool);
  const PointResponse& response = traced.responses[0][0];
  if (is_silent(response)) {
    throw InputError("--listener", "no sound reaches it", "place it in the room of the source");
  }
  const ResponseSynthesizer synthesizer({.sample_rate_hz = options.rate_hz,
                                         .duration_s = options.trace.duration_s,
                                         .seed = options.trace.seed});
  write_sound(options.output,
              render_response(options, synthesizer, response, listener.orientation, ears),
              SampleFormat::float32);
  warn_of_early_end(response, options.trace.duration_s);
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  if (options.report) {
    const Waveform mono = synthesizer.mono(response, 0);
    fmt::print("{}", trace_report(traced, mono.channel(0), options.rate_hz, passed.count()));
  }
}

void run(const TraceSetup& options, bool rate_given) {
  check_trace_setup(options);
  const bool moves = !options.source_path.empty() || !options.listener_path.empty();
  if (moves || !options.sound.empty()) {
    run_trace_motion(options, rate_given);
  } else {
    run_still(options);
  }
}

void add_motion(CLI::App& command, TraceSetup& options) {
  command.add_option("--source-path", options.source_path,
                     "Path of the source, instead of --source: CSV with the header "
                     "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg, in the scene's coordinates");
  command.add_option("--listener-path", options.listener_path,
                     "Path of the listener, instead of --listener: the same format");
  command.add_option("--sound", options.sound,
                     "A dry sound to play at the source: the sound at the listener is written "
                     "instead of the response, at its own rate unless --rate is given");
  command
      .add_option("--step", options.step_s,
                  "Seconds between the responses along a path; without --sound they are written "
                  "into a folder")
      ->capture_default_str();
}

void add_physics(CLI::App& command, TraceSetup& options) {
  TraceOptions& trace = options.trace;
  command.add_option("--rays", trace.rays, "Rays that leave the source")->capture_default_str();
  command.add_option("--bounces", trace.max_bounces, "Maximum number of reflections of a ray")
      ->capture_default_str();
  command.add_option("--duration", trace.duration_s, "Length of the response, seconds")
      ->capture_default_str();
  command.add_option("--seed", trace.seed, "The same seed gives the same response")
      ->check(whole_number())
      ->capture_default_str();
  command
      .add_option("--temperature", trace.air.temperature_celsius,
                  "Temperature of the air, degrees Celsius")
      ->capture_default_str();
  command
      .add_option("--humidity", trace.air.relative_humidity_percent,
                  "Relative humidity of the air, percent")
      ->capture_default_str();
  command.add_option("--jobs", options.jobs, "Threads; 0 takes all cores")->capture_default_str();
}

}  // namespace

void add_trace_command(CLI::App& app) {
  auto options = std::make_shared<TraceSetup>();
  CLI::App* command =
      app.add_subcommand("trace",
                         "Trace sound through a scene: the impulse response from a source "
                         "to a listener's two ears.");
  add_scene_argument(*command, options->scene);
  command->add_option(
      "--source", options->source,
      "Pose of the source: X,Y,Z[,yaw=DEG][,pitch=DEG][,roll=DEG], metres, z up; its level is "
      "that in front");
  command
      ->add_option("--directivity", options->directivity,
                   "Directivity of the source: omni, or speech (louder in front)")
      ->check(CLI::IsMember({"omni", "speech"}))
      ->capture_default_str();
  command->add_option(
      "--listener", options->listener,
      "Pose of the listener: X,Y,Z[,yaw=DEG][,pitch=DEG][,roll=DEG]; yaw 0 looks along x, "
      "90 along y");
  command
      ->add_option("-o,--output", options->output,
                   "Sound file to write (.wav or .w64); a folder for the responses along a path")
      ->required();
  command->add_flag("--mono", options->mono, "One omnidirectional microphone instead of two ears");
  command->add_option("--ambisonics", options->ambisonics,
                      "An ambisonic microphone of this order, 1 to 7: channels as ACN, norm N3D");
  CLI::Option* rate = command->add_option("--rate", options->rate_hz, "Samples per second");
  rate->capture_default_str();
  command->add_option("--hrtf", options->hrtf, "Head-related responses (.sofa)");
  add_motion(*command, *options);
  add_physics(*command, *options);
  command->add_flag("--report", options->report, "Print decay times, levels and cost");
  command->callback([options, rate] { run(*options, rate->count() > 0); });
}

}  // namespace earpoint

#include "trace_setup.h"

#include "flag_advice.h"
#include "trace_arguments.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/spatial/air_absorption.h>
#include <earpoint/trace/response_end.h>

namespace earpoint {

namespace {

constexpr double kLongest_s = 30.0;

}  // namespace

void check_trace_setup(const TraceSetup& options) {
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
  within("--step", options.step_s, 0.005, 10.0);
  const auto one_of = [](const char* flag, bool place, const char* path_flag, bool path) {
    if (place && path)
      throw InputError(path_flag, fmt::format("cannot be combined with {}", flag),
                       "give one of the two");
    if (!place && !path)
      throw InputError(flag, "is missing", fmt::format("give it or {}", path_flag));
  };
  one_of("--source", !options.source.empty(), "--source-path", !options.source_path.empty());
  one_of("--listener", !options.listener.empty(), "--listener-path",
         !options.listener_path.empty());
  if (options.ambisonics) {
    if (*options.ambisonics < 1 || *options.ambisonics > 7) {
      throw InputError("--ambisonics",
                       fmt::format("expected an order of 1 to 7, found {}", *options.ambisonics));
    }
    if (options.mono || options.hrtf) {
      throw InputError("--ambisonics", "cannot be combined with --mono or --hrtf",
                       "give one of the three");
    }
  }
  if (options.mono && options.hrtf) {
    throw InputError("--mono", "a single microphone has no HRTF", "leave out --mono or --hrtf");
  }
}

void check_place(const std::string& flag, const Vector3& place, const NamedScene& named) {
  const Bounds box = bounds(named.scene.mesh);
  check_inside(flag, place, {box.low + named.origin_m, box.high + named.origin_m});
}

void check_long_enough(const TraceSetup& options, double distance_m) {
  const double first_s = distance_m / speed_of_sound_m_per_s(options.trace.air);
  if (options.trace.duration_s > first_s) return;
  throw InputError("--duration",
                   fmt::format("ends after {:g} s, before the sound arrives after {:.3f} s",
                               options.trace.duration_s, first_s),
                   fmt::format("use --duration {:.1f} or more", first_s + 0.1));
}

void warn_of_early_end(const PointResponse& response, double duration_s) {
  const ResponseEnd end = response_end(response, duration_s);
  if (end.level_db <= -60.0 || duration_s >= kLongest_s) return;
  const double wanted_s = std::min(kLongest_s, std::ceil(10.0 * end.needed_s) / 10.0);
  fmt::print(stderr, "earpoint: warning: the response ends at {:.0f} dB; use {}\n", end.level_db,
             std::isfinite(end.needed_s) ? fmt::format("--duration {:g}", wanted_s)
                                         : "a longer --duration");
}

std::optional<HrtfSet> load_ears(const TraceSetup& options) {
  if (options.mono || options.ambisonics) return std::nullopt;
  return options.hrtf ? HrtfSet::load(*options.hrtf, options.rate_hz)
                      : HrtfSet::load(options.rate_hz);
}

Waveform render_response(const TraceSetup& options, const ResponseSynthesizer& synthesizer,
                         const PointResponse& response, const Quaternion& world_from_listener,
                         const std::optional<HrtfSet>& ears) {
  if (options.ambisonics) {
    return synthesizer.ambisonic(response, world_from_listener, *options.ambisonics, 0);
  }
  return ears ? synthesizer.binaural(response, world_from_listener, *ears, 0)
              : synthesizer.mono(response, 0);
}

bool is_silent(const PointResponse& response) {
  if (!response.arrivals.empty()) return false;
  for (int bin = 0; bin < response.late.bins(); ++bin) {
    for (const float energy : response.late.bin_energy(bin)) {
      if (energy > 0.0F) return false;
    }
  }
  return true;
}

Source make_source(const TraceSetup& options) {
  Source source;
  if (options.directivity == "speech") source.directivity = speech_directivity();
  return source;
}

NamedScene read_scene_with_warnings(const SceneArgument& argument) {
  NamedScene named = read_scene(argument);
  for (const std::string& warning : named.warnings) {
    fmt::print(stderr, "earpoint: {}: {}\n", argument.file.string(), with_flags(warning));
  }
  return named;
}

}  // namespace earpoint

#pragma once

#include "scene_argument.h"

#include <filesystem>
#include <optional>
#include <string>

#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/response_synthesizer.h>
#include <earpoint/trace/tracer.h>
#include <earpoint/waveform.h>

/// What `earpoint trace` is told; the places of what stands still are texts until they are parsed.
struct TraceSetup {
  SceneArgument scene;
  std::string source;
  std::string directivity = "omni";
  std::string listener;
  std::filesystem::path source_path;    ///< empty: the source stands still
  std::filesystem::path listener_path;  ///< empty: the listener stands still
  std::filesystem::path sound;          ///< empty: responses are wanted
  double step_s = 0.1;
  std::filesystem::path output;
  std::optional<std::filesystem::path> hrtf;
  std::optional<int> ambisonics;
  bool mono = false;
  bool report = false;
  int rate_hz = 16000;
  int jobs = 0;
  earpoint::TraceOptions trace;
};

/// @throws earpoint::InputError if a number is out of range or flags do not go together
void check_trace_setup(const TraceSetup& options);

/// A place outside of the model hears nothing, whatever the mesh.
/// @param flag   what the error names
/// @param place  in the user's coordinates
/// @throws earpoint::InputError
void check_place(const std::string& flag, const earpoint::Vector3& place, const NamedScene& named);

/// Sound takes its time: a response that ends before holds none.
/// @throws earpoint::InputError
void check_long_enough(const TraceSetup& options, double distance_m);

/// Says on standard error how long a response that was cut off should be.
void warn_of_early_end(const earpoint::PointResponse& response, double duration_s);

[[nodiscard]] bool is_silent(const earpoint::PointResponse& response);

/// The ears, where there are any.
/// @throws earpoint::InputError if they cannot be read
std::optional<earpoint::HrtfSet> load_ears(const TraceSetup& options);

/// What the microphone that was asked for hears.
earpoint::Waveform render_response(const TraceSetup& options,
                                   const earpoint::ResponseSynthesizer& synthesizer,
                                   const earpoint::PointResponse& response,
                                   const earpoint::Quaternion& world_from_listener,
                                   const std::optional<earpoint::HrtfSet>& ears);

/// @return a source that spreads as it was asked for, at the origin
earpoint::Source make_source(const TraceSetup& options);

/// As read_scene; warnings go to standard error.
NamedScene read_scene_with_warnings(const SceneArgument& argument);

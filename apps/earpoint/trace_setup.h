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

namespace earpoint {

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
  TraceOptions trace;
};

/// @throws InputError if a number is out of range or flags do not go together
void check_trace_setup(const TraceSetup& options);

/// A place outside of the model hears nothing, whatever the mesh.
/// @param flag   what the error names
/// @param place  in the user's coordinates
/// @throws InputError
void check_place(const std::string& flag, const Vector3& place, const NamedScene& named);

/// Sound takes its time: a response that ends before holds none.
/// @throws InputError
void check_long_enough(const TraceSetup& options, double distance_m);

/// Says on standard error how long a response that was cut off should be.
void warn_of_early_end(const PointResponse& response, double duration_s);

[[nodiscard]] bool is_silent(const PointResponse& response);

/// The ears, where there are any.
/// @throws InputError if they cannot be read
std::optional<HrtfSet> load_ears(const TraceSetup& options);

/// What the microphone that was asked for hears.
Waveform render_response(const TraceSetup& options, const ResponseSynthesizer& synthesizer,
                         const PointResponse& response, const Quaternion& world_from_listener,
                         const std::optional<HrtfSet>& ears);

/// @return a source that spreads as it was asked for, at the origin
Source make_source(const TraceSetup& options);

/// As read_scene; warnings go to standard error.
NamedScene read_scene_with_warnings(const SceneArgument& argument);

}  // namespace earpoint

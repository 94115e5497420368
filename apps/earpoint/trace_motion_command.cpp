#include "trace_motion_command.h"

#include "trace_arguments.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/trace/moving_sound.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

// A fixed pose or a path, and the flag that gave it.
struct Track {
  std::string flag;
  EarpointPath path;

  static Track read(const char* flag, const std::string& place, const char* path_flag,
                    const fs::path& file) {
    if (file.empty()) return {flag, EarpointPath(parse_pose(flag, place))};
    return {path_flag, EarpointPath::from_csv(file)};
  }

  // In the scene's own coordinates.
  [[nodiscard]] PoseOverTime from(const Vector3& origin_m) const {
    return [this, origin_m](double time_s) {
      Pose pose = path.at(time_s);
      pose.position_m = pose.position_m - origin_m;
      return pose;
    };
  }
};

struct Tracks {
  Track source;
  Track listener;

  [[nodiscard]] bool move() const { return source.path.is_moving() || listener.path.is_moving(); }
};

// Checks that source and listener are inside the scene and apart at every step, and that the
// response is long enough for the sound to arrive.
void check_steps(const TraceSetup& setup, const Tracks& tracks, const NamedScene& named,
                 int steps) {
  double farthest_m = 0.0;
  for (int step = 0; step < steps; ++step) {
    const double time_s = step * setup.step_s;
    const auto place_of = [&](const Track& track) {
      const Vector3 place = track.path.at(time_s).position_m;
      check_place(
          track.path.is_moving() ? fmt::format("{}: at {:g} s", track.flag, time_s) : track.flag,
          place, named);
      return place;
    };
    const double distance_m = norm(place_of(tracks.source) - place_of(tracks.listener));
    if (distance_m < 1e-3) {
      throw InputError(tracks.listener.flag,
                       fmt::format("is at the position of the source at {:g} s", time_s),
                       "move one of them");
    }
    farthest_m = std::max(farthest_m, distance_m);
  }
  check_long_enough(setup, farthest_m);
}

// One channel at the rate of the output; several are averaged.
std::vector<float> read_dry_sound(TraceSetup& setup, bool rate_given) {
  const Waveform file = read_sound(setup.sound);
  if (!rate_given) setup.rate_hz = file.sample_rate_hz();
  check_trace_setup(setup);
  const Waveform sound = resample(file, setup.rate_hz);
  std::vector<float> mono(sound.samples());
  for (int c = 0; c < sound.channels(); ++c) {
    const std::span<const float> channel = sound.channel(c);
    for (std::size_t i = 0; i < mono.size(); ++i) {
      mono[i] += channel[i] / static_cast<float>(sound.channels());
    }
  }
  return mono;
}

// A folder that is written under a temporary name and renamed when it is complete.
class ResponseFolder {
 public:
  explicit ResponseFolder(const fs::path& path)
      : path_(path), aside_(path.string() + fmt::format(".partial-{}", getpid())) {
    if (fs::exists(path_)) {
      throw InputError(path_.string(), "exists already", "choose a new folder");
    }
    fs::create_directories(aside_);
  }
  ~ResponseFolder() {
    std::error_code ignored;
    fs::remove_all(aside_, ignored);
  }
  ResponseFolder(const ResponseFolder&) = delete;
  ResponseFolder& operator=(const ResponseFolder&) = delete;

  void add(double time_s, const Pose& source, const Pose& listener, const Waveform& response) {
    const std::string name = fmt::format("{:05}.wav", count_++);
    write_sound(aside_ / name, response, SampleFormat::float32);
    index_ += fmt::format("{},{:.10g},{},{}\n", name, time_s, numbers(source), numbers(listener));
  }

  void finish() {
    write_file(aside_ / "index.csv", std::string_view(index_));
    std::error_code error;
    fs::rename(aside_, path_, error);
    if (error) throw InputError(path_.string(), error.message());
  }

 private:
  static std::string numbers(const Pose& pose) {
    const EulerAngles angles = euler_from_quaternion(pose.orientation);
    return fmt::format("{:.10g},{:.10g},{:.10g},{:.6g},{:.6g},{:.6g}", pose.position_m.x,
                       pose.position_m.y, pose.position_m.z, degrees_from_radians(angles.yaw_rad),
                       degrees_from_radians(angles.pitch_rad),
                       degrees_from_radians(angles.roll_rad));
  }

  fs::path path_;
  fs::path aside_;
  int count_ = 0;
  std::string index_ =
      "file,time_s,source_x,source_y,source_z,source_yaw_deg,source_pitch_deg,source_roll_deg,"
      "listener_x,listener_y,listener_z,listener_yaw_deg,listener_pitch_deg,listener_roll_deg\n";
};

// Refuses a motion during which no sound arrives, and warns once of a response that is cut off.
class Watch {
 public:
  explicit Watch(double duration_s) : duration_s_(duration_s) {}
  void see(const PointResponse& response) {
    if (heard_ || is_silent(response)) return;
    heard_ = true;
    warn_of_early_end(response, duration_s_);
  }
  void check(const Track& listener) const {
    if (heard_) return;
    throw InputError(listener.flag, "no sound reaches it", "place it in the room of the source");
  }

 private:
  double duration_s_;
  bool heard_ = false;
};

}  // namespace

void run_trace_motion(TraceSetup setup, bool rate_given) {
  if (setup.report)
    throw InputError("--report", "works for a single response only", "leave it out");
  const Tracks tracks{
      Track::read("--source", setup.source, "--source-path", setup.source_path),
      Track::read("--listener", setup.listener, "--listener-path", setup.listener_path)};
  const bool plays = !setup.sound.empty();
  std::vector<float> sound;
  double duration_s = std::max(tracks.source.path.end_s(), tracks.listener.path.end_s());
  if (plays) {
    sound = read_dry_sound(setup, rate_given);
    duration_s = static_cast<double>(sound.size()) / setup.rate_hz;
    if (!tracks.move()) setup.step_s = duration_s + setup.trace.duration_s;
  }
  tracks.source.path.check_covers(duration_s);
  tracks.listener.path.check_covers(duration_s);
  const std::optional<HrtfSet> ears = load_ears(setup);
  const NamedScene named = read_scene_with_warnings(setup.scene);

  const Motion motion{.world_from_source = tracks.source.from(named.origin_m),
                      .world_from_listener = tracks.listener.from(named.origin_m),
                      .step_s = setup.step_s};
  const RenderOptions render{.sample_rate_hz = setup.rate_hz,
                             .duration_s = setup.trace.duration_s,
                             .seed = setup.trace.seed};
  const Source source = make_source(setup);
  ThreadPool pool(setup.jobs > 0 ? setup.jobs : available_cores());
  Watch watch(setup.trace.duration_s);
  if (plays) {
    MovingSound moving(std::move(sound), motion, render, setup.trace.air,
                       {.ears = ears, .ambisonic_order = setup.ambisonics});
    check_steps(setup, tracks, named, moving.steps());
    const AcousticScene scene(named.scene);
    trace_motion(scene, source, motion, moving.steps(), setup.trace, pool,
                 [&](int step, const PointResponse& response) {
                   watch.see(response);
                   moving.add(step, response);
                 });
    watch.check(tracks.listener);
    write_sound(setup.output, moving.take(), SampleFormat::float32);
    return;
  }
  // The last step is the first one at or after the path's end, where it stands still.
  const int steps = 1 + static_cast<int>(std::ceil(duration_s / setup.step_s - 1e-9));
  check_steps(setup, tracks, named, steps);
  const AcousticScene scene(named.scene);
  const ResponseSynthesizer synthesizer(render);
  ResponseFolder folder(setup.output);
  trace_motion(scene, source, motion, steps, setup.trace, pool,
               [&](int step, const PointResponse& response) {
                 watch.see(response);
                 const double time_s = step * setup.step_s;
                 const Pose listener = tracks.listener.path.at(time_s);
                 folder.add(
                     time_s, tracks.source.path.at(time_s), listener,
                     render_response(setup, synthesizer, response, listener.orientation, ears));
               });
  watch.check(tracks.listener);
  folder.finish();
}

}  // namespace earpoint

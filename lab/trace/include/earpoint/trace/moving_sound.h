#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <earpoint/core/parallel.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/response_synthesizer.h>
#include <earpoint/trace/tracer.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Where something is over time, in the world's frame: continuous, defined for every time.
using PoseOverTime = std::function<Pose(double time_s)>;

/// A source and a listener, of which one or both move.
struct Motion {
  PoseOverTime world_from_source;
  PoseOverTime world_from_listener;
  double step_s = 0.1;  ///< responses are traced so far apart, > 0
};

/// What hears: two ears, an ambisonic microphone, or by default one omnidirectional one.
struct Microphone {
  std::optional<HrtfSet> ears{};
  std::optional<int> ambisonic_order{};  ///< 0 to 7; not with ears
};

/// Traces the responses at times 0, step, 2 step, ...; both stand still for each of them.
/// @param source  its pose is taken from the motion
/// @param steps   > 0
/// @param handle  called in order, with the step and what is heard there
/// @throws InputError as trace()
void trace_motion(const AcousticScene& scene, const Source& source, const Motion& motion, int steps,
                  const TraceOptions& options, ThreadPool& pool,
                  const std::function<void(int step, const PointResponse& response)>& handle);

/// Plays a sound through the responses along a motion.
///
/// The direct sound and the strongest arrivals of the first 50 ms after it are delayed by the true
/// length of their way at every moment, from where the source was when it sent to where the
/// listener is: the Doppler shift is exact for the direct sound, and for reflections where one of
/// the two stands still. Directions, levels and all later sound are those of the steps, faded into
/// each other; the late field is the same noise at every step, so that it fades without a dip.
class MovingSound {
 public:
  /// @param sound    dry, shape [samples], at the rate of `options`
  /// @param options  the duration is that of every response
  /// @param air      as it was traced with
  /// @throws std::logic_error if an option is out of range, or the ears have another rate
  MovingSound(std::vector<float> sound, Motion motion, const RenderOptions& options, const Air& air,
              Microphone microphone);
  ~MovingSound();
  MovingSound(MovingSound&&) noexcept;
  MovingSound& operator=(MovingSound&&) noexcept;

  /// How many steps the sound and its decay need.
  [[nodiscard]] int steps() const;

  /// @param step      each of 0 to steps() - 1 once, in any order
  /// @param response  of where both are at step * step_s
  void add(int step, const PointResponse& response);

  /// @return what was heard, from the sound's first sample on, with its decay; sample 0 is the
  ///         moment of emission; shape [channels][sound + duration]
  [[nodiscard]] Waveform take();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Both together: traces along the motion and plays the sound.
/// @param sound  dry, shape [samples], at `sample_rate_hz`
[[nodiscard]] Waveform trace_motion(const AcousticScene& scene, const Source& source,
                                    const Motion& motion, std::span<const float> sound,
                                    int sample_rate_hz, const Microphone& microphone,
                                    const TraceOptions& options, ThreadPool& pool);

}  // namespace earpoint

#pragma once

#include <cstdint>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/record_simulation/session_plan.h>
#include <earpoint/scene/scene.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/tracer.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// How a session is heard.
struct SessionSoundQuality {
  int rays = 1000;          ///< from each mouth
  int mirror_rays = 3000;   ///< that look for image sources
  double response_s = 0.8;  ///< of the responses
  double step_s = 0.3;      ///< between the traces while somebody moves
};

/// What every device would hear if all had one clock and nothing hissed: sample i is at session
/// time i / rate.
struct SessionSound {
  std::vector<Waveform> cameras;      ///< [2][samples]
  std::vector<Waveform> microphones;  ///< of people, [1][samples]
};

/// The scene with its people at a moment; person i is instances[people[i].instance].
struct PeopledScene {
  Scene scene;
  std::vector<Person> people;
};
PeopledScene scene_with_people(const Scene& scene, const SessionPlan& plan, double time_s);

/// Traces the speech of a session to all devices. While nobody concerned moves, one response serves
/// all of a turn; while the speaker or a microphone's wearer walks, responses are traced every
/// `step_s` and faded (`MovingSound`). The bodies of all people stand in the way, where they are at
/// the time of each trace.
/// @param rate_hz  of the sound and of `hrtf`; the rate of the turns
/// @param jobs     threads; have no effect on the result
/// @throws InputError as trace()
SessionSound hear_speech(const PreparedScene& scene, const SessionPlan& plan,
                         const SessionSoundQuality& quality, const HrtfSet& hrtf,
                         std::uint64_t seed, int jobs, ProgressSink& progress);

/// Adds the clap at full bandwidth.
/// @param sound  at the rate of `hrtf`
void add_clap(const PreparedScene& scene, const SessionPlan& plan,
              const SessionSoundQuality& quality, const HrtfSet& hrtf, std::uint64_t seed,
              SessionSound& sound);

}  // namespace earpoint

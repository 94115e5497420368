#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/camera/scene_drawer.h>
#include <earpoint/generate/conversation_plan.h>
#include <earpoint/generate/stage_clock.h>
#include <earpoint/scene/scene.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/response_synthesizer.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// A scene without people, ready for conversations. Immutable.
struct PreparedScene {
  /// @param scene_on_the_floor  as `check_scene` leaves it, its floor at height 0
  PreparedScene(std::string scene_name, Scene scene_on_the_floor);

  std::string name;
  Scene scene;
  RayCaster caster;
  FloorMap floor;
  SceneDrawer drawer;  ///< its light is solved once for all conversations
};

/// A procedural home: its floor lies at height 0 already.
std::shared_ptr<const PreparedScene> prepare_home(std::string name, Scene scene);

/// Any other scene: it is moved so that most of its floor lies at height 0.
std::shared_ptr<const PreparedScene> prepare_scan(std::string name, Scene scene);

/// How a conversation is seen and heard.
struct ConversationQuality {
  int sample_rate_hz = 16000;
  double duration_s = 1.0;  ///< of the responses
  int rays = 5000;          ///< from each speaker
  int image_width = 256;
  int image_height = 256;
  double horizontal_fov_rad = kPi / 2.0;
  int samples_per_side = 2;  ///< of the pictures: its square per pixel
};

/// What one viewpoint sees and hears.
struct SimulatedViewpoint {
  Pose world_from_listener;
  Image rgb;
  FloatImage depth_m;
  std::array<std::optional<Box>, 2> boxes;  ///< by person; nothing if hidden
  std::array<Waveform, 2> responses;        ///< by person: binaural, [2][samples]
  std::array<Waveform, 2> heard;  ///< by person: the same with speech, if that was asked for
};

struct SimulatedConversation {
  std::array<Person, 2> people;
  std::vector<SimulatedViewpoint> viewpoints;
  std::array<double, 2> escape_fractions{};  ///< by person
  /// The reverberation time (T20) at the first viewpoint, first person; nothing if the response
  /// does not decay far enough.
  std::optional<double> reverberation_s;
};

/// Simulates conversations: one trace from both mouths serves all viewpoints. Holds tables: make
/// one and keep it. Const calls may be made from many threads at once; each uses one thread.
class ConversationSimulator {
 public:
  /// @throws InputError if no HRTF is installed
  explicit ConversationSimulator(const ConversationQuality& quality);

  /// @param seed   of rays, noise and pixels: the same gives the same bytes
  /// @param clock  is told how long each stage takes
  /// @throws InputError if more than 1 % of the sound escapes through holes of the scene
  [[nodiscard]] SimulatedConversation simulate(const PreparedScene& scene,
                                               const ConversationPlan& plan, std::uint64_t seed,
                                               StageClock& clock) const;

  [[nodiscard]] const ConversationQuality& quality() const { return quality_; }

 private:
  void hear(const std::string& name, const Scene& scene, std::uint64_t seed,
            SimulatedConversation& conversation, StageClock& clock) const;
  void see(const SceneDrawer& camera, std::uint64_t seed,
           SimulatedConversation& conversation) const;

  ConversationQuality quality_;
  HrtfSet hrtf_;
  ResponseSynthesizer synthesizer_;
};

/// What a viewpoint hears of a person's speech.
/// @param speech    one channel, at the response's rate
/// @param response  two channels
/// @return shape [2][speech + response - 1 samples]
Waveform heard_speech(const Waveform& speech, const Waveform& response);

/// Silences what lies before the straight way's travel time, less 2 ms for the head's size and the
/// ringing of band-limited pulses: what a loader drops as the delay is then the travel time.
/// @param response    its level there is rounding and ringing
/// @param distance_m  straight from the source
void silence_before_arrival(Waveform& response, double distance_m);

}  // namespace earpoint

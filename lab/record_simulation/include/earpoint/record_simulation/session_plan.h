#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/generate/conversation.h>
#include <earpoint/generate/speech_corpus.h>
#include <earpoint/pose.h>
#include <earpoint/record/session_truth.h>
#include <earpoint/record_simulation/person_path.h>
#include <earpoint/record_simulation/spoken_turns.h>
#include <earpoint/scene/people.h>

namespace earpoint {

/// What a simulated session looks like.
struct SessionOptions {
  std::optional<int> people{};    ///< 2 to 4; drawn if left open
  int cameras = 8;                ///< 1 or more
  double duration_s = 180.0;      ///< of session time, >= 10
  double most_drift_ppm = 50.0;   ///< of a clock, either way; drawn evenly; >= 0
  double most_offset_s = 2.0;     ///< between the starts of the recordings; drawn evenly; >= 0
  double frame_rate_hz = 5.0;     ///< of the pictures, > 0
  double sitting_share = 0.35;    ///< of the people, but one at least stands
  double walks_per_minute = 5.0;  ///< of all people together, >= 0
};

/// Somebody in a session.
struct SessionFigure {
  std::string name;                      ///< "person-1", ...
  const FigureModel* figure = nullptr;   ///< owned by the library it was drawn from
  const SpeechSpeaker* voice = nullptr;  ///< owned by the corpus
  PersonPath path;
  Vector3 microphone_m;  ///< of the near microphone from the mouth, in the head's frame

  /// @return the mouth and where it speaks to
  [[nodiscard]] Pose world_from_mouth(double time_s) const;
  [[nodiscard]] Vector3 microphone_at(double time_s) const;
};

/// Everything that happens in a session, and where its devices are.
struct SessionPlan {
  double duration_s = 0.0;
  std::vector<Pose> world_from_camera;  ///< level in roll; its ears are those of a head there
  std::vector<SessionFigure> people;
  std::vector<Utterance> turns;
  double clap_s = 0.0;  ///< session time
  Vector3 clap_m;
  /// Of cameras, then of microphones. A camera's offset is a multiple of its time between pictures,
  /// within 10 ms: so pictures of all cameras can be taken at the same moments.
  std::vector<DeviceClock> clocks;
  std::vector<double> ends_s;  ///< session time at which the device stops, as clocks
};

/// Draws a session in a scene: where the cameras stand, who is there, walks, sits and speaks.
/// @throws InputError if the scene has no room for it, or the corpus too few voices of the split
SessionPlan plan_session(const PreparedScene& scene, const FigureLibrary& figures,
                         const SpeechCorpus& corpus, DataSplit split, const SessionOptions& options,
                         RandomStream& random);

/// The mouths' course of a person for truth.json: every 0.1 s while it moves.
std::vector<TrackPoint> track_of(const SessionFigure& person, double duration_s);

}  // namespace earpoint

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/image.h>
#include <earpoint/locate/active_speaker.h>
#include <earpoint/locate/people_detector.h>
#include <earpoint/locate/person_tracker.h>
#include <earpoint/locate/voice_direction.h>
#include <earpoint/render/source_stream.h>
#include <earpoint/render_files/render.h>
#include <earpoint/synthesis/speaker_track.h>

namespace earpoint {

/// One of five moments a second of a recording.
struct PeopleFrame {
  double time_s = 0.0;
  std::vector<TrackedPerson> people;
  SpeakerBelief belief;  ///< who of them speaks

  /// Whether that person speaks now: 0 to 1.
  [[nodiscard]] double speaking(std::size_t person) const {
    return belief.voice * belief.people[person];
  }
};

/// Who is in a recording's picture and who of them speaks, over time.
struct PeopleInClip {
  std::vector<PeopleFrame> frames;  ///< not empty
  std::string detector;             ///< what found them; "none" where nothing looked
  bool has_picture = false;
  bool hears_direction = false;  ///< the sound told who speaks; else only who is there
};

/// What a recording tells of its speaker, all in all.
struct SpeakerSummary {
  int people = 0;              ///< tracks that were ever seen
  std::optional<int> speaker;  ///< who speaks for most of the time; nothing: somebody outside
  double outside_share = 0.0;  ///< of the time in which anybody speaks: somebody outside
  double certainty = 0.0;      ///< mean probability of the most probable at each moment
};

/// How people are looked for and listened to.
struct PeopleSearch {
  PeopleDetector* detector = nullptr;  ///< null: nobody is looked for
  double horizontal_fov_rad = 0.0;     ///< of the source camera
  bool hears_direction = true;  ///< the sound is binaural; else it tells only when somebody speaks
};

/// Looks and listens through a recording from end to end. With a speaker's track in `source` nobody
/// is looked for: that is the one person, and the sound tells only when they speak. Memory: 200
/// bytes a second and person.
/// @param survey  of the source's sound
/// @throws InputError for a bad recording or picture; if the head that directions are heard by is
///         missing
[[nodiscard]] PeopleInClip find_people(const RenderInput& source, const SoundSurvey& survey,
                                       const PeopleSearch& search, ProgressSink& progress);

/// Where the most probable speaker is seen; nothing if no person ever is.
[[nodiscard]] std::optional<SpeakerTrack> speaker_track(const PeopleInClip& people);

[[nodiscard]] SpeakerSummary summary_of(const PeopleInClip& people);

/// CSV with a row for every moment and person: time_s,track,x0,y0,x1,y1,speaking,voice.
/// SpeakerTrack reads it.
[[nodiscard]] std::string csv_of(const PeopleInClip& people);

/// Who is in one picture and who of them speaks in a short sound.
struct PeopleInPicture {
  std::vector<DetectedPerson> people;
  SpeakerBelief belief;            ///< over the whole sound
  double heard_azimuth_rad = 0.0;  ///< where the voice comes from by the sound alone

  /// Where the most probable speaker is seen; nothing: not in the picture.
  [[nodiscard]] std::optional<Box> speaker_box() const;
};

/// Listens to short sounds beside still pictures, as data sets have them.
class StillSpeakerFinder {
 public:
  /// @param head                at 16 kHz
  /// @param horizontal_fov_rad  of the camera
  StillSpeakerFinder(const HrtfSet& head, double horizontal_fov_rad);

  /// @param people  in the picture
  /// @param sound   2 ears, 16 kHz
  [[nodiscard]] PeopleInPicture find(std::vector<DetectedPerson> people, const Waveform& sound);

 private:
  double horizontal_fov_rad_;
  VoiceDirection direction_;
};

}  // namespace earpoint

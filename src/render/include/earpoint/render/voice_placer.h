#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <earpoint/audio/stereo_check.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/synthesis/speaker_track.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The position for a voice that was not recorded binaurally, and how it is taken from the two
/// channels.
struct VoicePlacement {
  struct Row {
    double time_s = 0.0;
    Vector3 mouth_m;  ///< in the source view's frame
  };
  std::vector<Row> rows;               ///< not empty, times grow; in between places move linearly
  StereoKind kind = StereoKind::same;  ///< what the two channels are

  [[nodiscard]] Vector3 at(double time_s) const;
};

/// The mouth stays at one place.
[[nodiscard]] VoicePlacement placed_at(const Vector3& mouth_m, StereoKind kind);

/// The mouth follows the boxes, by speaker_direction_from_box(); while there is none, it is where
/// it is seen next or was seen last.
/// @param horizontal_fov_rad  of the whole picture
/// @param picture             its size in pixels; nothing: square
/// @return nothing if there is never a box
[[nodiscard]] std::optional<VoicePlacement> placed_at(const SpeakerTrack& track, StereoKind kind,
                                                      double horizontal_fov_rad,
                                                      const SpeakerTrack::PictureSize& picture);

/// Turns a recording that is not binaural into one that is: both channels become one, which the
/// head's filters put at the speaker's mouth. It is as loud as it was at the microphone: distance
/// gives no gain, as the recording has it already. All of the sound comes from there, its
/// reverberation as well.
class VoicePlacer {
 public:
  /// @param head  at the recording's rate
  VoicePlacer(VoicePlacement placement, const HrtfSet& head);
  ~VoicePlacer();
  VoicePlacer(VoicePlacer&&) noexcept;
  VoicePlacer& operator=(VoicePlacer&&) noexcept;

  /// @param block  shape [2][any]
  /// @return       what is ready, [2][any]; in step with the sound at the head's middle
  [[nodiscard]] Waveform process(const Waveform& block);
  /// The rest: all together as long as what was put in.
  [[nodiscard]] Waveform finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

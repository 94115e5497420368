#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/error.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/synthesis/speaker_track.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// How a synthesizer wants a clip cut up. Windows start every `samples - overlap` samples.
struct WindowShape {
  int sample_rate_hz = 0;
  std::ptrdiff_t samples = 0;  ///< length of one window
  std::ptrdiff_t overlap = 0;  ///< shared with the next window and cross-faded, < samples
  std::ptrdiff_t context = 0;  ///< further samples wanted on either side of the window
  /// Samples from one pose of a moving target to the next; 0: one pose has to do for a window.
  std::ptrdiff_t pose_step = 0;
};

/// What is known at the source view during one window.
struct Observation {
  /// The primary sound at the source view: 2 ears, [context + samples + context].
  Waveform sound;
  /// The frame nearest to the window's middle; null where there is no picture. While a picture
  /// stands still, every window has the same one.
  std::shared_ptr<const Image> picture;
  /// Where the speaker is seen in that frame; nothing: out of sight, or not known.
  std::optional<Box> speaker_box;
  /// Where the speaker's mouth is, in the source view's frame.
  std::optional<Vector3> speaker_m;
  /// Where the source view stands in the recording's world, for networks that learned poses in the
  /// world's axes. Nothing where only relative poses are known: it then looks along x.
  std::optional<Pose> world_from_source{};
};

/// When a synthesizer looks at the picture.
enum class PictureUse {
  never,
  with_box,  ///< only where the speaker is known by a box alone
  if_there,  ///< always, but it does without where there is none
  always,
};

/// A whole rendering as a synthesizer is asked for it.
struct RenderOutline {
  double duration_s = 0.0;
  double level_db = 0.0;  ///< of the recording's louder ear, root mean square re full scale
  bool has_picture = false;
  std::optional<SpeakerTrack> speaker_track;
  std::optional<Vector3> speaker_m;
  std::vector<EarpointPath> targets;
};

/// Turns what was heard at the source view into what is heard at a target view, one window at a
/// time. A synthesizer first observes a window, then renders it for any number of targets, so that
/// what depends on the source alone (image features, inverse filters) is computed once.
///
/// Target poses are `source_from_target`: where the target's head stands in the source's frame.
class AcousticSynthesizer {
 public:
  virtual ~AcousticSynthesizer() = default;

  /// @param source_rate_hz  the recording's rate; a synthesizer without a rate of its own takes it
  [[nodiscard]] virtual WindowShape window_shape(int source_rate_hz) const = 0;

  /// Sound below this frequency is ambient: it bypasses the synthesizer and is added back. 0: none.
  [[nodiscard]] virtual double ambient_cutoff_hz() const { return 0.0; }

  [[nodiscard]] virtual PictureUse picture_use() const { return PictureUse::never; }

  /// Whether boxes of the speaker must be known, be they in sight or not.
  [[nodiscard]] virtual bool needs_speaker_track() const { return false; }

  /// What of a rendering lies outside of what it was made for: a reason each, for people.
  [[nodiscard]] virtual std::vector<std::string> warnings(const RenderOutline& /*outline*/) const {
    return {};
  }

  /// Another one that makes the same of a window, so that threads can render different windows at
  /// once. Null: windows must be rendered one after the other, for instance because this one uses
  /// several threads for each.
  [[nodiscard]] virtual std::unique_ptr<AcousticSynthesizer> twin() const { return nullptr; }

  /// @throws InputError naming what this synthesizer needs and does not get
  virtual void observe(const Observation& observation) = 0;

  /// @return 2 ears, [samples] of the window observed last, at the window's rate
  [[nodiscard]] virtual Waveform synthesize(const Pose& source_from_target) = 0;

  /// The same for a target that moves. Only for synthesizers whose windows have a pose_step.
  /// @param path  source_from_target at sample 0, pose_step, ...: 1 + samples / pose_step poses
  [[nodiscard]] virtual Waveform synthesize_along(std::span<const Pose> path) {
    EARPOINT_CHECK(path.size() == 1);
    return synthesize(path.front());
  }
};

}  // namespace earpoint

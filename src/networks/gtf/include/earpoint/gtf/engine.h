#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// What a network keeps in mind of a sound: its level, and how its ears relate.
struct GtfStatistics {
  float level = 0.0F;  ///< root mean square over both ears
  std::vector<float> summary;
};

/// Where a network takes the speaker to be, in the source's frame.
struct GtfSpeaker {
  Vector3 position_m;    ///< of the mouth
  double yaw_rad = 0.0;  ///< the way they face; 0 is the source's front
  /// How sure it is of that way, 0 to 1: the length of the mean of all ways that it thinks
  /// possible.
  double yaw_certainty = 0.0;
};

/// A geometric time-frequency network, ready to run on the processor. Either window by window,
///
///   set_picture(), set_pose(), synthesize()
///
/// or as a stream, hop by hop, whose conditions may change at any hop:
///
///   start(), then set_picture() and set_pose() whenever something changes, and advance().
///
/// Both are exactly equivariant to gain, up to rounding, above -80 dB re full scale. Nothing
/// allocates after the first window of a length. One caller at a time, one thread.
class Gtf {
 public:
  explicit Gtf(const GtfWeights& weights);
  ~Gtf();
  Gtf(Gtf&&) noexcept;
  Gtf& operator=(Gtf&&) noexcept;

  [[nodiscard]] const GtfDescription& description() const;

  /// What the source's camera sees from here on, as gtf_view() has it.
  /// @param picture  [3][picture_px][picture_px]; empty if the network does not look
  void set_picture(std::span<const float> picture, const std::optional<Box>& speaker_box);

  /// Where the target is from here on, and the speaker's mouth if it is known, both in the source's
  /// frame. Pitch and roll turn the ears; what was learned knows the yaw alone. A place beyond the
  /// range of the training data (GtfTrainingRange) is heard as the nearest one within it, and by as
  /// much weaker as the way to it costs the direct sound; the diffuse field stays.
  void set_pose(const Pose& source_from_target, const std::optional<Vector3>& speaker_m = {});

  /// Which texture is rendered from here on, in a network that has been told it in training: 0 the
  /// mean of what is possible, with the least error of magnitudes; 1 a natural one, with the depth
  /// of modulation and the decay of such a sound. 1 from the start.
  void ask_for_texture(double texture);

  /// The sound at the target of a window on its own.
  /// @param source  planar, [2][samples], left ear first, at 16 kHz, samples >= 400
  /// @param output  the same size; must not overlap it
  void synthesize(std::span<const float> source, std::span<float> output);

  /// The same for a target that moves, in place of the pose that set_pose() was given.
  /// @param path  source_from_target at every frame, which is at every hop of samples:
  ///              1 + samples / hop poses. Equal neighbours cost nothing more than standing still
  void synthesize(std::span<const float> source, std::span<const Pose> path,
                  std::span<float> output);

  /// The dry voice in a window, as a microphone hears it 1 m before the mouth in free field, on
  /// time with the direct sound at the source. Of a network that tells it
  /// (GtfDescription::dry_voice).
  /// @param source  as synthesize() takes it
  /// @param voice   [samples]
  void tell_voice(std::span<const float> source, std::span<float> voice);

  /// Finds the speaker by what was looked at and a window of sound, which statistics() then tells
  /// of.
  /// @param source  as synthesize() takes it
  /// @return nothing if the network knows no geometry
  [[nodiscard]] std::optional<GtfSpeaker> locate(std::span<const float> source);

  /// Power that the geometry of the move alone expects, both ears together, over that of the
  /// source's: the direct sound falls with distance, the diffuse field is the same everywhere. Of
  /// the window that synthesize() made, or of a stream's last second, were it all heard at the
  /// present pose. 1 at the source itself, and if the network knows no geometry.
  [[nodiscard]] double expected_gain() const;

  /// What synthesize() or locate() heard in its window.
  [[nodiscard]] const GtfStatistics& statistics() const;

  /// Begins a stream at silence.
  /// @param statistics    held throughout; without them running means of about a second are taken
  /// @param phase_rounds  at most those of the description, the default; each one less saves 20 ms
  ///                      of latency, and the phases of frames agree less
  void start(std::optional<GtfStatistics> statistics = {}, std::optional<int> phase_rounds = {});

  /// The next hop of a stream: source in, and out what lies latency_samples() back.
  /// @param source  planar, [2][hop]
  /// @param output  planar, [2][hop]
  void advance(std::span<const float> source, std::span<float> output);

  /// By how much the output of a stream is later than its input: the frames ahead, those that its
  /// phase rounds need, and the window.
  [[nodiscard]] std::ptrdiff_t latency_samples() const;

  /// Where the speaker was taken to be, in the source's frame; nothing without geometry.
  [[nodiscard]] std::optional<Vector3> speaker_m() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

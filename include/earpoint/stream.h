#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include <earpoint/export.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>

namespace earpoint {

/// How sound arrives at a Stream.
struct StreamOptions {
  int sample_rate_hz = 48000;  ///< from 16000 to 192000, a multiple of 50
  /// Carry what lies above the network's band (8 kHz) along at the gain of its top octave.
  bool extend_band = true;
  bool limit = true;  ///< keep the output within full scale
  /// Rounds that make the phases of frames agree; each makes the stream 20 ms later. Nothing: as
  /// many as the network was trained with; 0: none, and the least latency.
  std::optional<int> phase_rounds{};
};

/// Live sound from another earpoint, block by block; made by Renderer::stream().
///
/// process(), move_to() and place_speaker() allocate nothing and take no lock, so that an audio
/// thread may call them; see() computes and allocates. Calls must not overlap: one thread at a
/// time, or a lock of the caller's. Streams share nothing: each may have its own thread.
class EARPOINT_API Stream {
 public:
  ~Stream();
  Stream(Stream&&) noexcept;
  Stream& operator=(Stream&&) noexcept;

  /// What the source's camera sees from here on. Not for the audio thread.
  /// @param picture      RGB, any size
  /// @param speaker_box  where the speaker is seen in it; nothing: to be found
  void see(const Image& picture, const std::optional<Box>& speaker_box = std::nullopt);

  /// The same without a picture: where the speaker is seen by a camera whose picture is not known,
  /// or nothing at all. As every stream begins.
  void see_nothing(const std::optional<Box>& speaker_box = std::nullopt);

  /// Where the speaker's mouth is, metres in the source's frame; nothing: to be found by picture
  /// and sound.
  /// @throws InputError if it is not finite or farther than 10 km
  void place_speaker(const std::optional<Vector3>& mouth_m);

  /// Where the earpoint is from here on: its head in the source's frame.
  /// @throws InputError if it is not finite or farther than 10 km
  void move_to(const Pose& source_from_target);

  /// Renders the next samples.
  /// @param in      left and right ear of the source, [2][frames]; NaN and infinity count as 0
  /// @param out     left and right ear of the earpoint, [2][frames], latency_samples() late; may be
  ///                the memory of `in`
  /// @param frames  any number, another one in every call
  void process(const float* const* in, float* const* out, std::ptrdiff_t frames);

  /// How late the output is, in samples at the stream's rate; whatever the size of the blocks.
  [[nodiscard]] std::ptrdiff_t latency_samples() const;

  /// Where the network takes the speaker's mouth to be, metres in the source's frame; nothing
  /// before it has heard something.
  [[nodiscard]] std::optional<Vector3> speaker_m() const;

  /// Back to silence; picture, speaker and earpoint stay.
  void reset();

 private:
  friend class Renderer;
  struct State;
  explicit Stream(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include <earpoint/export.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>

namespace earpoint {

/// Options of a Stream.
struct StreamOptions {
  int sample_rate_hz = 48000;  ///< from 16000 to 192000, a multiple of 50
  /// Sound above the network's band (8 kHz) follows the gain of its top octave. gtf only.
  bool extend_band = true;
  bool limit = true;  ///< keep the output within full scale
  /// Rounds that make the phases of frames consistent; each adds 20 ms of latency. Nothing: as
  /// many as the network was trained with, which is the most; 0: none, and the lowest latency.
  std::optional<int> phase_rounds{};
};

/// Live sound at an earpoint, block by block; made by Renderer::stream().
///
/// process(), move_to() and place_speaker() allocate nothing and take no lock, so an audio
/// thread may call them; see() computes and allocates. Calls must not overlap: one thread at a
/// time, or with the caller's lock. Streams share nothing: each may have its own thread.
class EARPOINT_API Stream {
 public:
  ~Stream();
  Stream(Stream&&) noexcept;
  Stream& operator=(Stream&&) noexcept;

  /// The source camera's picture from here on. Not for the audio thread.
  /// @param picture      RGB, any size
  /// @param speaker_box  box of the speaker in it; nothing: unknown
  /// @throws InputError if the box is no box within the picture
  /// @throws std::logic_error if the picture is not RGB
  void see(const Image& picture, const std::optional<Box>& speaker_box = std::nullopt);

  /// The same without a picture: the speaker's box for a camera whose picture is unknown, or
  /// nothing at all. Every stream starts like this.
  /// @throws InputError as see(), and for `dsp` if there is a box: its direction depends on the
  ///         picture's shape
  void see_nothing(const std::optional<Box>& speaker_box = std::nullopt);

  /// Position of the speaker's mouth, metres in the source's frame; nothing: located by picture
  /// and sound. `dsp` takes the speaker to be 1 m away in the box's direction, and passes the sound
  /// unchanged if it knows neither.
  /// @throws InputError if it is not finite or farther than 10 km
  void place_speaker(const std::optional<Vector3>& mouth_m);

  /// The earpoint from here on: pose of its head in the source's frame.
  /// @throws InputError if its place or orientation is not finite, or it is farther than 10 km
  void move_to(const Pose& source_from_target);

  /// Renders the next samples.
  /// @param in      left and right ear of the source, [2][frames]; NaN and infinity count as 0
  /// @param out     left and right ear of the earpoint, [2][frames], latency_samples() late; may be
  ///                the memory of `in`, also with the ears swapped
  /// @param frames  >= 0, may change with every call
  void process(const float* const* in, float* const* out, std::ptrdiff_t frames);

  /// Latency of the output, in samples at the stream's rate, for any block size.
  [[nodiscard]] std::ptrdiff_t latency_samples() const;

  /// Estimated position of the speaker's mouth, metres in the source's frame; nothing
  /// before the first sound, or if `dsp` was told nothing.
  [[nodiscard]] std::optional<Vector3> speaker_m() const;

  /// Restarts from silence; picture, speaker and earpoint are kept.
  void reset();

 private:
  friend class Renderer;
  struct State;
  explicit Stream(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

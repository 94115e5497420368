#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>

namespace earpoint {

/// The signal-processing baseline (DspSynthesizer) for sound that arrives live, in blocks of any
/// size: filters for the earpoint of that moment, cross-faded every 40 ms while it moves. Standing
/// still, the output is that of DspSynthesizer.
///
/// Without a known speaker the sound passes unchanged. process(), move_to() and place_speaker()
/// allocate nothing and take no lock. While the earpoint moves, process() designs filters once in
/// 40 ms of sound, which takes 1 to 3 ms. One caller at a time.
class DspStream {
 public:
  struct Options {
    double horizontal_fov_rad = radians_from_degrees(90.0);  ///< of the source camera
    bool limit = true;                                       ///< keep the output within full scale
  };

  /// @param head  at the stream's rate
  DspStream(const HrtfSet& head, const Options& options);
  ~DspStream();
  DspStream(DspStream&&) noexcept;
  DspStream& operator=(DspStream&&) noexcept;

  /// Where the speaker is seen, if they are not placed: their direction, taken to be 1 m away.
  /// @param picture      RGB; only its size matters
  /// @param speaker_box  normalised; nothing: unknown
  /// @throws InputError if there is a box and no picture
  void see(const Image* picture, const std::optional<Box>& speaker_box);

  /// Where the speaker's mouth is, in the source's frame; nothing: where they are seen.
  /// @throws InputError if it is not finite or absurdly far
  void place_speaker(const std::optional<Vector3>& mouth_m);

  /// Where the earpoint is from here on: source_from_target.
  /// @throws InputError if it is not finite or absurdly far
  void move_to(const Pose& source_from_target);

  /// @param in   left and right ear, as many samples each; what is no number counts as 0
  /// @param out  the sound at the earpoint, of the same size, latency_samples() late; may be the
  ///             memory of `in`
  void process(std::array<std::span<const float>, 2> in, std::array<std::span<float>, 2> out);

  /// At the stream's rate, whatever the size of the blocks: 10 ms, half of the filters' length (40
  /// ms), and 5 ms of the limiter.
  [[nodiscard]] std::ptrdiff_t latency_samples() const;

  /// Where the speaker's mouth is taken to be; nothing if it is unknown.
  [[nodiscard]] std::optional<Vector3> speaker_m() const;

  /// Back to silence; picture, speaker and earpoint stay.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

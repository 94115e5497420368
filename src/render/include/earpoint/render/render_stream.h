#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include <earpoint/gtf/weights.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>

namespace earpoint {

/// gtf for sound that arrives live, in blocks of any size at any usual rate, as a plugin or a page
/// hands it over. The earpoint may move at any time. What the network's rate does not carry and
/// ambient sound go along, as in render(); the level is held and peaks are limited as there. What a
/// live stream cannot have is the whole recording: ambient sound is split off by a causal
/// crossover, which turns phases near its edge, and level, summary and the gain of the band above
/// the model follow the last second.
///
/// process() allocates nothing and takes no lock; see() may allocate. One caller at a time.
class RenderStream {
 public:
  struct Options {
    int sample_rate_hz = 48000;  ///< from 16000 to 192000, a multiple of 50
    double horizontal_fov_rad = radians_from_degrees(90.0);  ///< of the source camera
    bool extend_band = true;  ///< carry the band above the model's along
    bool limit = true;        ///< keep the output within full scale
    /// Rounds that make the phases of frames agree; each makes the stream 20 ms later. By default
    /// the network's own, as in render(); 0 has the lowest latency.
    std::optional<int> phase_rounds{};
    /// As SynthesizerOptions has it.
    std::optional<double> texture{};
  };

  /// @throws InputError if the rate is none of those
  RenderStream(const GtfWeights& weights, const Options& options);
  ~RenderStream();
  RenderStream(RenderStream&&) noexcept;
  RenderStream& operator=(RenderStream&&) noexcept;

  /// The source camera's picture from here on.
  /// @param picture      RGB of any size; null: nothing
  /// @param speaker_box  where the speaker is seen in it, if that is known
  void see(const Image* picture, const std::optional<Box>& speaker_box);

  /// Where the speaker's mouth is, in the source's frame; nothing: to be found.
  /// @throws InputError if it is not finite or absurdly far
  void place_speaker(const std::optional<Vector3>& mouth_m);

  /// Where the earpoint is from here on: source_from_target.
  /// @throws InputError if it is not finite or absurdly far
  void move_to(const Pose& source_from_target);

  /// @param in   left and right ear, as many samples each; what is no number counts as 0
  /// @param out  the sound at the earpoint, of the same size, latency_samples() late; may be the
  ///             memory of `in`
  void process(std::array<std::span<const float>, 2> in, std::array<std::span<float>, 2> out);

  /// At the stream's rate, whatever the size of the blocks.
  [[nodiscard]] std::ptrdiff_t latency_samples() const;

  /// Where the network takes the speaker's mouth to be; nothing before it has heard something.
  [[nodiscard]] std::optional<Vector3> speaker_m() const;

  /// Back to silence; picture, speaker and earpoint stay.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

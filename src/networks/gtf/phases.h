#pragma once

#include "frames.h"

#include <array>
#include <complex>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <earpoint/gtf/description.h>

namespace earpoint::gtf {

/// A frame on its way through the rounds; both ears, [2][bins].
struct GtfPhaseFrame {
  GtfPhaseFrame();

  std::vector<std::complex<float>> turned;  ///< as the last round left it
  std::vector<std::complex<float>> heard;   ///< the transform that it took its phases from
  std::vector<float> magnitude;             ///< that all rounds keep
  float power_floor = 0.0F;                 ///< below it a bin has no phase
};

/// One round of fast Griffin-Lim over frames that come one by one: each frame's phases become those
/// of the transform of what it and its neighbours sound like. It leaves kOverlappingFrames later
/// than it comes.
class GtfPhaseRound {
 public:
  GtfPhaseRound();

  /// Restarts. @param end  of the sound: silence from that sample on
  void reset(std::ptrdiff_t end);
  /// Takes the next frame in. Allocates nothing.
  /// @return whether `frame` now is the one that leaves
  bool take(GtfPhaseFrame& frame);
  /// After the last frame, the next one that is still inside. Allocates nothing.
  /// @return false if there is none
  bool drain(GtfPhaseFrame& frame);

 private:
  static constexpr std::ptrdiff_t kLate = GtfDescription::kOverlappingFrames;

  void turn(GtfPhaseFrame& frame);
  void read_samples(std::ptrdiff_t end);

  GtfFrames frames_{kLate};
  std::ptrdiff_t end_ = 0;
  std::ptrdiff_t in_ = 0;    ///< frames
  std::ptrdiff_t out_ = 0;   ///< frames
  std::ptrdiff_t read_ = 0;  ///< samples
  std::array<GtfPhaseFrame, kLate + 1> waiting_;
  std::array<float, std::size_t{2} * GtfDescription::kFrameSamples> recent_{};
};

/// All rounds of a network, one after the other.
class GtfPhases {
 public:
  /// @param most_rounds  that reset() may ask for
  explicit GtfPhases(int most_rounds) : rounds_(static_cast<std::size_t>(most_rounds)) {}

  /// Rounds in use. Each makes frames leave kOverlappingFrames later.
  [[nodiscard]] int rounds() const { return static_cast<int>(active_); }
  /// Restarts with that many rounds.
  /// @param end  of the sound: silence from that sample on; none in a stream
  void reset(int rounds, std::ptrdiff_t end = std::numeric_limits<std::ptrdiff_t>::max());

  /// Takes the next frame. Allocates nothing.
  /// @param spectra  [2][bins], at the scale of the output; receives the frame that leaves
  /// @param scale    of the output over that at which the network hears
  /// @return whether one leaves
  bool take(std::span<std::complex<float>> spectra, float scale);
  /// The same after the last frame.
  bool drain(std::span<std::complex<float>> spectra);

 private:
  bool leave_through(std::size_t first_round, std::span<std::complex<float>> spectra);

  std::vector<GtfPhaseRound> rounds_;
  std::size_t active_ = 0;  ///< the first ones
  GtfPhaseFrame frame_;
};

}  // namespace earpoint::gtf

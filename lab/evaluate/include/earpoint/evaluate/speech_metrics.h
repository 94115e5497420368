#pragma once

#include <memory>
#include <optional>
#include <span>

namespace earpoint {

/// Beyond it a scale-invariant ratio is rounding: the largest that si_sdr_db() returns.
inline constexpr double kLargestSiSdrDb = 100.0;

/// Scale-invariant signal-to-distortion ratio: the energy of what of the estimate is a multiple of
/// the reference over that of the rest. The mean is not removed.
/// @param reference, estimate  one channel, of one length
/// @return dB, at most kLargestSiSdrDb and at least -kLargestSiSdrDb; nothing where the reference
///         or the estimate is silent
/// Source: Le Roux et al., SDR - half-baked or well done?, ICASSP 2019.
[[nodiscard]] std::optional<double> si_sdr_db(std::span<const float> reference,
                                              std::span<const float> estimate);

/// Extended short-time objective intelligibility: 1 for the reference itself, about 0 for
/// unrelated sound. Both are brought to 10 kHz; frames of the reference that are more than 40 dB
/// below its loudest are left out of both; then 15 third-octave bands from 150 Hz are compared over
/// segments of 30 frames (384 ms), normalised along time and along the bands.
/// One object per thread: it keeps its plans.
/// Source: Jensen and Taal, IEEE/ACM Trans. ASLP 24 (2016).
class Estoi {
 public:
  static constexpr int kLowestRate_hz = 10000;

  Estoi();
  ~Estoi();
  Estoi(Estoi&&) noexcept;
  Estoi& operator=(Estoi&&) noexcept;

  /// @param reference, estimate  one channel, of one length
  /// @param sample_rate_hz       at least kLowestRate_hz
  /// @return nothing where less than 30 frames of the reference are speech
  [[nodiscard]] std::optional<double> measure(std::span<const float> reference,
                                              std::span<const float> estimate, int sample_rate_hz);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

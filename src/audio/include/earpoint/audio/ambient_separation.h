#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <earpoint/waveform.h>

namespace earpoint {

/// How the primary sound, speech, is separated from the ambient sound of a recording. The ambient
/// sound is what the primary sound leaves of the recording: both together are the recording.
enum class AmbientSeparation {
  bandpass,  ///< what is below a cutoff is ambient; zero-phase Butterworth (butterworth.h)
  subtract,  ///< power spectral subtraction of tracked noise
  mmse,      ///< log-spectral amplitude estimator (log-MMSE) with tracked noise
};

/// "bandpass", "subtract" or "mmse".
[[nodiscard]] std::string_view name_of(AmbientSeparation separation);
/// All names, in the order of AmbientSeparation.
[[nodiscard]] std::span<const std::string_view> ambient_separation_names();
/// @return nothing for another word
[[nodiscard]] std::optional<AmbientSeparation> ambient_separation_named(std::string_view name);

/// Removes stationary and slowly changing noise from a stream of sound, frame by frame.
///
/// Frames of about 32 ms (for whole fast transforms) with a hop of a quarter and square-root Hann
/// windows. The noise's power spectrum is tracked by minima-controlled recursive averaging
/// (NoiseTracker) over the sum of all channels. One gain for each frame and bin applies to all
/// channels, which keeps the level and time differences between the ears.
/// - subtract: G^2 = max(1 - 1/gamma, floor^2), gamma = power / noise, floor -20 dB.
/// - mmse: G = xi/(1+xi) exp(E1(v)/2), v = gamma xi/(1+xi), xi by the decision-directed approach
///   (weight 0.98), at least -25 dB.
///
/// Look-ahead: a sample is given once the frame that begins with it or before is known, at most a
/// frame later; the first ones after a second, from which the noise is first estimated.
/// Source: Boll, IEEE Trans. ASSP 27 (1979); Ephraim and Malah, IEEE Trans. ASSP 33 (1985).
class NoiseSuppressor {
 public:
  /// @param separation      subtract or mmse
  /// @param channels        > 0
  /// @param sample_rate_hz  at least 8000
  /// @param cutoff_hz       bins below are removed altogether; 0: none
  NoiseSuppressor(AmbientSeparation separation, int channels, int sample_rate_hz, double cutoff_hz);
  ~NoiseSuppressor();
  NoiseSuppressor(NoiseSuppressor&&) noexcept;
  NoiseSuppressor& operator=(NoiseSuppressor&&) noexcept;

  /// @param block  [channels][any number of samples], what comes next
  /// @param last   nothing comes after it: all that is left is given
  /// @return the primary sound that is known now and was not given before
  [[nodiscard]] Waveform process(const Waveform& block, bool last);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The same of a whole sound. @return [channels][samples]
[[nodiscard]] Waveform suppress_noise(const Waveform& sound, AmbientSeparation separation,
                                      double cutoff_hz);

}  // namespace earpoint

#pragma once

#include <memory>
#include <vector>

#include <earpoint/spatial/hrtf.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// What a stretch of binaural sound tells of the direction that a voice comes from.
struct DirectionEvidence {
  /// Logarithm of the likelihood by azimuth, up to a constant: entry i is for the azimuth
  /// -pi + i * 2 pi / size in the horizontal plane, counter-clockwise from front. Empty: the sound
  /// tells nothing of direction, as mono does.
  std::vector<double> log_likelihood;
  double power = 0.0;  ///< mean over both ears and the stretch

  /// Likelihood, up to the constant, of a voice about that azimuth: the mean over azimuths with
  /// Gaussian weights. @param spread_rad  > 0
  [[nodiscard]] double likelihood_near(double azimuth_rad, double spread_rad) const;
  /// The mean over all azimuths that are farther than that from front. @param beyond_rad  < pi
  [[nodiscard]] double likelihood_outside(double beyond_rad) const;
  /// The likeliest azimuth.
  [[nodiscard]] double azimuth_rad() const;
};

/// Listens for the direction of a voice by the phase between the ears.
///
/// Short-time spectra (32 ms every 8 ms, 200 Hz to 7 kHz); every bin votes for the azimuths at
/// which the head gives the phase between the ears that it has (steered response with phase
/// transform, with the head's own phases instead of a free-field delay). Bins whose power rises
/// count most: there the direct sound has come and its reflections have not. Front and back sound
/// nearly alike by phase, and both get the evidence. A vote's weight was fitted to simulated homes,
/// so that the likelihoods are about as sure as they are right. Sources: DiBiase (2000), SRP-PHAT;
/// Zurek, "The precedence effect" (1987).
class VoiceDirection {
 public:
  static constexpr int kSampleRateHz = 16000;
  static constexpr int kDirections = 72;

  /// @param head  at 16 kHz
  explicit VoiceDirection(const HrtfSet& head);
  ~VoiceDirection();
  VoiceDirection(VoiceDirection&&) noexcept;
  VoiceDirection& operator=(VoiceDirection&&) noexcept;

  /// What the next samples tell, together with what was heard just before them.
  /// @param block  2 ears, 16 kHz, finite
  [[nodiscard]] DirectionEvidence listen(const Waveform& block);

  /// Forgets what was heard: another recording follows.
  void start();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

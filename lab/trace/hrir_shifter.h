#pragma once

#include <complex>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>

namespace earpoint {

/// Moves impulse responses of ears by fractions of a sample: a phase ramp, exact below Nyquist.
/// Holds its own work space: use one per thread.
class HrirShifter {
 public:
  /// @param taps  of the responses
  explicit HrirShifter(int taps);

  /// Samples of a shifted response.
  [[nodiscard]] int size() const { return fft_.size(); }
  /// Samples of it that come before the first tap: the shift rings to both sides.
  [[nodiscard]] int lead() const { return kRinging; }

  /// @param taps      shape [taps]
  /// @param fraction  of a sample, later; in [0, 1)
  /// @param shifted   shape [size]
  void shift(std::span<const float> taps, double fraction, std::span<float> shifted);

 private:
  static constexpr int kRinging = 64;

  RealFft<float> fft_;
  std::vector<std::complex<float>> spectrum_;
};

}  // namespace earpoint

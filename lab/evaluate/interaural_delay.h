#pragma once

#include <complex>
#include <optional>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// How much later a sound reaches the right ear than the left, by the cross-correlation with phase
/// transform between the ears: its largest value within 1 ms, more than any head's width. A
/// correlation four times as fine as the samples, and a parabola through its three largest values:
/// good to 0.02 sample. Bins 60 dB below the mean count less than others, so that what a high-pass
/// has left, rounding noise, does not vote. The ends are faded over 10 ms.
/// One object per thread. Source: Knapp and Carter, IEEE Trans. ASSP 24 (1976).
class InterauralDelay {
 public:
  /// @param binaural  2 ears, [samples]
  /// @return seconds, positive if the left ear hears it first; nothing if an ear is silent
  [[nodiscard]] std::optional<double> measure_s(const Waveform& binaural);

 private:
  void plan(int size, int sample_rate_hz);
  void transform(std::span<const float> ear, std::vector<std::complex<float>>& spectrum);

  std::optional<RealFft<float>> fft_;
  std::optional<RealFft<float>> fine_fft_;
  std::vector<std::complex<float>> left_;
  std::vector<std::complex<float>> right_;
  std::vector<std::complex<float>> cross_;
  std::vector<float> fade_;
  std::vector<float> padded_;
  std::vector<float> correlation_;
};

}  // namespace earpoint

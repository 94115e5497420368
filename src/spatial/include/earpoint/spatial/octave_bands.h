#pragma once

#include <span>
#include <vector>

#include <earpoint/core/octave_bands.h>

namespace earpoint {

/// The octave bank of arrivals and late tails: eight zero-phase bands whose *amplitudes* sum to
/// one at every frequency. On a logarithmic frequency axis a band is a raised cosine that is one
/// at its own centre and zero at its neighbours'; the lowest stays one down to 0 Hz, the highest
/// up to Nyquist. So a set of band gains reads as a smooth gain curve through the centres:
/// - equal gains give back the sound exactly, and coherent arrivals add up as they should;
/// - for noise, shape *one* broadband noise by the gains. Noises drawn apart for each band would
///   lose up to 3 dB between the centres;
/// - zero phase keeps an arrival's peak at its time. The price is a short ringing on both sides
///   (`octave_bank_half_length`), weak as neighbouring gains are alike.

/// @param band          0 (62.5 Hz) to 7 (8 kHz)
/// @param frequency_hz  >= 0
/// @return the band's amplitude, in [0, 1]
[[nodiscard]] double octave_band_weight(int band, double frequency_hz);

/// How far the bank rings to each side of an arrival, in samples: 32 ms. Beyond lies less than
/// -46 dB of the energy of the two lowest bands, -76 dB of the 500 Hz band, and so on: 15 dB less
/// per octave. A frame of a circular convolution should leave as much room on both sides.
[[nodiscard]] int octave_bank_half_length(int sample_rate_hz);

/// The bank on the bins of a real DFT.
class OctaveBank {
 public:
  /// @param sample_rate_hz  > 0
  /// @param fft_size        even, > 0
  OctaveBank(int sample_rate_hz, int fft_size);

  [[nodiscard]] int bins() const { return bins_; }

  /// @return one band's amplitude per bin, shape [bins]
  [[nodiscard]] std::span<const float> weights(int band) const;

  /// Writes the curve sum_b gain[b] weight[b] of pressure gains.
  /// @param curve  shape [bins]
  void gain_curve(const BandArray& gains, std::span<float> curve) const;

 private:
  int bins_;
  std::vector<float> weights_;  // [band][bin]
  std::vector<int> lower_;      // per bin: the lower of the two bands that it lies between
};

}  // namespace earpoint

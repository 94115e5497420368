#pragma once

#include <array>
#include <complex>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/core/octave_bands.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint {

/// Turns pulses that fall between samples into a spectrum with exact phases: they are spread over a
/// few points of a grid twice as fine, transformed, and the spreading is divided out of the
/// spectrum (a non-uniform FFT of type 1; Barnett et al., SIAM J. Sci. Comput. 41, 2019). Error:
/// below 1e-6 of the largest bin, whatever the position and up to the Nyquist frequency.
class PulseTrain {
 public:
  /// @param fft_size  of the spectrum; even. Positions are taken round its end.
  explicit PulseTrain(int fft_size);

  /// Forgets all pulses.
  void clear();

  /// @param gains  area of the pulse in each band
  void add(double position_samples, const BandArray& gains);

  /// Adds the pulses, each band through its filter of the bank.
  /// @param sum  shape [fft_size / 2 + 1]
  void add_spectrum(const OctaveBank& bank, std::span<std::complex<float>> sum);

 private:
  RealFft<float> fft_;
  std::vector<float> correction_;                       // [bin]
  std::array<std::vector<float>, kOctaveBands> grids_;  // [band][point]
  std::vector<std::complex<float>> spectrum_;
};

}  // namespace earpoint

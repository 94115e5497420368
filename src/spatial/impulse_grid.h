#pragma once

#include <array>
#include <complex>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/core/octave_bands.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint {

/// Many impulses at any time, each with its own gain per band, as one spectrum.
///
/// A nonuniform Fourier transform: every impulse is spread over eight points of a grid of twice
/// the rate by a Kaiser-Bessel kernel, whose own spectrum is divided out after the transform. Times
/// are exact: the error is that of float32, below 3e-6 of the sum of gains, at every frequency.
/// Source: Fessler and Sutton, IEEE Trans. Signal Processing 51 (2003); kernel by Beatty et al.
class ImpulseGrid {
 public:
  /// @param size  of the spectrum's signal in samples, even; times wrap round at it
  ImpulseGrid(int sample_rate_hz, int size);

  /// Bins of spectrum(): size / 2 + 1.
  [[nodiscard]] int bins() const { return bank_.bins(); }

  /// @param time_samples  in [8, size - 8)
  void add(double time_samples, const BandArray& gain);

  /// Writes the spectrum of all that was added since, the bands joined, and forgets it.
  /// @param spectrum  shape [bins]
  void take(std::span<std::complex<float>> spectrum);

 private:
  OctaveBank bank_;
  RealFft<float> fft_;
  std::vector<float> kernel_;                          // half of it, finely sampled
  std::vector<float> correction_;                      // per bin
  std::array<std::vector<float>, kOctaveBands> grid_;  // [band][point]
  std::vector<std::complex<float>> work_;
};

}  // namespace earpoint

#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace earpoint {

/// A filter of second order, (b0 + b1/z + b2/z^2) / (1 + a1/z + a2/z^2).
struct SecondOrderSection {
  double b0 = 1.0;
  double b1 = 0.0;
  double b2 = 0.0;
  double a1 = 0.0;
  double a2 = 0.0;
};

/// Butterworth band-pass as a cascade, poles nearest to the unit circle last, the whole gain in the
/// first section.
/// @param low_hz, high_hz  edges at -3 dB, 0 < low_hz < high_hz < sample_rate_hz / 2
/// @param order            > 0; the filter has 2 * order poles, hence `order` sections
/// Source: analogue prototype, band-pass and bilinear transforms with prewarping (Oppenheim and
/// Schafer, Discrete-Time Signal Processing, chapter 7).
[[nodiscard]] std::vector<SecondOrderSection> butterworth_bandpass(double low_hz, double high_hz,
                                                                   double sample_rate_hz,
                                                                   int order = 5);

/// Two filters that share the spectrum and whose outputs add up to all of it, the phase turned.
struct Crossover {
  std::vector<SecondOrderSection> low;
  std::vector<SecondOrderSection> high;
};

/// Linkwitz-Riley crossover of order 8: both are -6 dB at the cutoff and fall by 48 dB an octave;
/// the sum is an all-pass.
/// @param cutoff_hz  0 < cutoff_hz < sample_rate_hz / 2
/// Source: Linkwitz, JAES 24 (1976): a Butterworth filter, here of order 4, twice.
[[nodiscard]] Crossover linkwitz_riley(double cutoff_hz, double sample_rate_hz);

/// How many samples filter_zero_phase() extends each end by: it needs more than these.
[[nodiscard]] std::ptrdiff_t zero_phase_extension(std::span<const SecondOrderSection> sections);

/// Filters forwards and backwards: twice the attenuation, no delay. The ends are extended by odd
/// reflection, and each pass starts from the steady state for its first sample.
/// @param in   shape [samples], samples > zero_phase_extension(sections)
/// @param out  same shape; may be the same memory
/// Source: Gustafsson, IEEE Trans. SP 44 (1996), compares the ways to start such filters.
void filter_zero_phase(std::span<const SecondOrderSection> sections, std::span<const double> in,
                       std::span<double> out);

/// The same sections as a causal filter for a live stream, sample by sample, from silence.
class SectionFilter {
 public:
  explicit SectionFilter(std::span<const SecondOrderSection> sections);

  double process(double sample);
  /// Back to silence.
  void reset();

 private:
  struct Running {
    SecondOrderSection section;
    double z1 = 0.0;
    double z2 = 0.0;
  };
  std::vector<Running> running_;
};

}  // namespace earpoint

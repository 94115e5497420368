#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/audio/gcc_phat.h>
#include <earpoint/core/error.h>

namespace earpoint {
namespace {

constexpr int kInterpolation = 16;

using Spectrum = std::vector<std::complex<double>>;

Spectrum spectrum_of(std::span<const float> signal, RealFft<double>& fft) {
  std::vector<double> padded(fft.size());
  std::ranges::copy(signal, padded.begin());
  Spectrum spectrum(fft.bins());
  fft.forward(padded, spectrum);
  return spectrum;
}

/// G / |G| with G = signal * conj(reference). @return false if a bin of G is zero
bool whiten(Spectrum& signal, const Spectrum& reference) {
  for (std::size_t k = 0; k < signal.size(); ++k) {
    const std::complex<double> a = signal[k];
    const std::complex<double> b = reference[k];
    const std::complex<double> cross(a.real() * b.real() + a.imag() * b.imag(),
                                     a.imag() * b.real() - a.real() * b.imag());
    const double magnitude = std::abs(cross);
    if (magnitude == 0.0) return false;
    signal[k] = {cross.real() / magnitude, cross.imag() / magnitude};
  }
  return true;
}

}  // namespace

double gcc_phat_delay_samples(std::span<const float> signal, std::span<const float> reference,
                              double max_delay_samples) {
  EARPOINT_CHECK(!signal.empty() && !reference.empty() && max_delay_samples >= 0.0);
  const auto n = static_cast<int>(signal.size() + reference.size());
  RealFft<double> fft(n);
  Spectrum cross = spectrum_of(signal, fft);
  double delay = -n / 2.0;
  if (whiten(cross, spectrum_of(reference, fft))) {
    RealFft<double> fine_fft(kInterpolation * n);
    cross.resize(fine_fft.bins());
    std::vector<double> correlation(fine_fft.size());
    fine_fft.inverse(cross, correlation);
    // From the most negative lag to the most positive one, which wrap to the same element.
    const int largest_lag = kInterpolation * n / 2;
    double peak = -1.0;
    for (int lag = -largest_lag; lag <= largest_lag; ++lag) {
      const double value = std::abs(correlation[lag < 0 ? lag + fine_fft.size() : lag]);
      if (value > peak) {
        peak = value;
        delay = static_cast<double>(lag) / kInterpolation;
      }
    }
  }
  return std::clamp(delay, -max_delay_samples, max_delay_samples);
}

}  // namespace earpoint

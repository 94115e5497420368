#include <earpoint/audio/gcc_phat.h>

#include "roots_of_unity.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

/// Lags are counted in steps of 1/16 sample. The correlation is computed at every fourth of them,
/// and in between only where its maximum can be.
constexpr int kSteps = 16;
constexpr int kCoarseSteps = 4;
constexpr int kCoarsePerSample = kSteps / kCoarseSteps;

/// The correlation c is a trigonometric polynomial of degree n/2, so that arccos(c / max|c|) cannot
/// change faster than by pi/16 per step (the inequality of Bernstein and Szegoe). The largest value
/// on the grid of steps is at most half a step from the true maximum, and the nearest coarse lag at
/// most two steps from that: it has at least cos(2.5 pi / 16) of the maximum.
const double kCandidateLevel = std::cos(2.5 * 3.14159265358979323846 / kSteps);

/// With more candidates than this (noise against noise) every lag is computed.
constexpr int kMostCandidates = 48;

using Complex = std::complex<double>;
using Spectrum = std::vector<Complex>;

/// A lag and |correlation| there.
struct Peak {
  std::int64_t lag_steps = 0;
  double value = -1.0;

  /// Larger wins; of equal ones the earlier lag.
  void update(std::int64_t lag, double new_value) {
    if (new_value > value || (new_value == value && lag < lag_steps)) {
      lag_steps = lag;
      value = new_value;
    }
  }
};

Complex product(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// signal = G / |G| with G = signal * conj(reference). @return false if a bin of G is zero
bool whiten(Spectrum& signal, const Spectrum& reference) {
  for (std::size_t k = 0; k < signal.size(); ++k) {
    const Complex cross = product(signal[k], std::conj(reference[k]));
    const double magnitude = std::abs(cross);
    if (magnitude == 0.0) return false;
    signal[k] = cross / magnitude;
  }
  return true;
}

}  // namespace

struct GccPhat::State {
  State(int signal, int reference)
      : signal_samples(signal),
        reference_samples(reference),
        n(signal + reference),
        fft(n),
        coarse_fft(kCoarsePerSample * n),
        roots(std::int64_t{kSteps} * n),
        cross(fft.bins()),
        reference_spectrum(fft.bins()),
        padded_spectrum(coarse_fft.bins()),
        padded(n),
        correlation(coarse_fft.size()) {}

  void transform(std::span<const float> signal, Spectrum& spectrum) {
    std::ranges::fill(padded, 0.0);
    std::ranges::copy(signal, padded.begin());
    fft.forward(padded, spectrum);
  }

  /// The correlation at lags 4 j + offset (in steps), j = 0 ... 4 n - 1, times 4 n / (16 n).
  void correlate_at_offset(int offset_steps) {
    for (std::size_t k = 0; k < cross.size(); ++k) {
      const auto turn = static_cast<std::int64_t>(k) * offset_steps;
      padded_spectrum[k] = offset_steps == 0 ? cross[k] : product(cross[k], roots.at(turn));
    }
    coarse_fft.inverse(padded_spectrum, correlation);
  }

  /// The same at one lag, by the definition.
  [[nodiscard]] double correlation_at(std::int64_t lag_steps) const {
    double sum = 0.0;
    std::int64_t turn = 0;
    for (std::size_t k = 1; k < cross.size(); ++k) {
      turn += lag_steps;
      if (turn >= std::int64_t{kSteps} * n) turn -= std::int64_t{kSteps} * n;
      sum += product(cross[k], roots.at(turn)).real();
    }
    return (cross[0].real() + 2.0 * sum) / coarse_fft.size();
  }

  /// Lags wrap: those of the second half are negative, and the middle is both; it counts as the
  /// negative one, which comes first.
  [[nodiscard]] std::int64_t signed_lag(std::int64_t steps) const {
    const std::int64_t all = std::int64_t{kSteps} * n;
    return 2 * steps >= all ? steps - all : steps;
  }

  Peak search_everywhere() {
    Peak peak;
    for (int offset = 0; offset < kCoarseSteps; ++offset) {
      correlate_at_offset(offset);
      for (std::size_t j = 0; j < correlation.size(); ++j) {
        const auto steps = static_cast<std::int64_t>(j) * kCoarseSteps + offset;
        peak.update(signed_lag(steps), std::abs(correlation[j]));
      }
    }
    return peak;
  }

  Peak search() {
    correlate_at_offset(0);
    double largest = 0.0;
    for (const double c : correlation) largest = std::max(largest, std::abs(c));
    // A little lower, for rounding.
    const double level = largest * (kCandidateLevel - 1e-9);
    Peak peak;
    int candidates = 0;
    for (std::size_t j = 0; j < correlation.size(); ++j) {
      if (std::abs(correlation[j]) < level) continue;
      if (++candidates > kMostCandidates) return search_everywhere();
      const std::int64_t all = std::int64_t{kSteps} * n;
      const auto steps = static_cast<std::int64_t>(j) * kCoarseSteps;
      peak.update(signed_lag(steps), std::abs(correlation[j]));
      for (const int step : {-2, -1, 1, 2}) {
        const std::int64_t near = (steps + step + all) % all;
        peak.update(signed_lag(near), std::abs(correlation_at(near)));
      }
    }
    return peak;
  }

  int signal_samples;
  int reference_samples;
  int n;
  RealFft<double> fft;
  RealFft<double> coarse_fft;
  RootsOfUnity roots;
  Spectrum cross;
  Spectrum reference_spectrum;
  Spectrum padded_spectrum;
  std::vector<double> padded;
  std::vector<double> correlation;
};

GccPhat::GccPhat(int signal_samples, int reference_samples) {
  EARPOINT_CHECK(signal_samples > 0 && reference_samples > 0);
  state_ = std::make_unique<State>(signal_samples, reference_samples);
}
GccPhat::~GccPhat() = default;
GccPhat::GccPhat(GccPhat&&) noexcept = default;
GccPhat& GccPhat::operator=(GccPhat&&) noexcept = default;

double GccPhat::delay_samples(std::span<const float> signal, std::span<const float> reference) {
  State& s = *state_;
  EARPOINT_CHECK(std::ssize(signal) == s.signal_samples &&
                 std::ssize(reference) == s.reference_samples);
  s.transform(signal, s.cross);
  s.transform(reference, s.reference_spectrum);
  if (!whiten(s.cross, s.reference_spectrum)) return -s.n / 2.0;
  return static_cast<double>(s.search().lag_steps) / kSteps;
}

double gcc_phat_delay_samples(std::span<const float> signal, std::span<const float> reference,
                              double max_delay_samples) {
  EARPOINT_CHECK(!signal.empty() && !reference.empty() && max_delay_samples >= 0.0);
  GccPhat estimator(static_cast<int>(signal.size()), static_cast<int>(reference.size()));
  return std::clamp(estimator.delay_samples(signal, reference), -max_delay_samples,
                    max_delay_samples);
}

}  // namespace earpoint

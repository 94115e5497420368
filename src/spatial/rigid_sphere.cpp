#include <earpoint/spatial/rigid_sphere.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;

constexpr double kSpeedOfSound_m_per_s = 343.2;
constexpr double kNearest_m = 0.1;
constexpr double kLowest_hz = 1.0;  // the series' limit at 0 Hz, without dividing by 0

double clamped_distance_m(double distance_m) { return std::max(distance_m, kNearest_m); }

// Spherical Hankel functions of the first kind.
Complex hankel_0(double x) { return std::polar(1.0 / x, x - kPi / 2.0); }
Complex hankel_1(double x) { return -std::polar(1.0 / x, x) * Complex(1.0, 1.0 / x); }

}  // namespace

std::array<Complex, 2> rigid_sphere_ears(double frequency_hz, double distance_m,
                                         double towards_left) {
  EARPOINT_CHECK(frequency_hz >= 0.0 && std::abs(towards_left) <= 1.0 + 1e-9);
  const double mu =
      2.0 * kPi * std::max(frequency_hz, kLowest_hz) * kHeadRadius_m / kSpeedOfSound_m_per_s;
  const double rho = clamped_distance_m(distance_m) / kHeadRadius_m;
  const double far = mu * rho;

  // The recurrence of h_m / h_{m-1} is stable upwards and, unlike that of h_m, does not overflow.
  Complex far_ratio = hankel_1(far) / hankel_0(far);
  Complex near_ratio = hankel_1(mu) / hankel_0(mu);
  Complex quotient = hankel_0(far) / hankel_0(mu);
  // Terms of even and of odd order: the ears see opposite sides of the odd ones.
  std::array<Complex, 2> sums = {-quotient / near_ratio, 0.0};
  double legendre_before = 1.0;
  double legendre = towards_left;
  constexpr int kMostTerms = 1000;
  constexpr double kNegligible = 1e-7;
  for (int m = 1; m < kMostTerms; ++m) {
    quotient *= far_ratio / near_ratio;
    const Complex derivative = 1.0 / near_ratio - (m + 1) / mu;  // h'_m / h_m
    const Complex factor = (2.0 * m + 1.0) * quotient / derivative;
    sums[m % 2] += factor * legendre;
    if (m > mu && std::abs(factor) < kNegligible * std::abs(sums[0])) break;
    far_ratio = (2.0 * m + 1.0) / far - 1.0 / far_ratio;
    near_ratio = (2.0 * m + 1.0) / mu - 1.0 / near_ratio;
    const double next = ((2.0 * m + 1.0) * towards_left * legendre - m * legendre_before) / (m + 1);
    legendre_before = legendre;
    legendre = next;
  }
  // The series is for the time dependence exp(-i w t), so conjugate.
  const Complex scale = -rho / mu * std::polar(1.0, -far);
  return {std::conj(scale * (sums[0] + sums[1])), std::conj(scale * (sums[0] - sums[1]))};
}

std::array<double, 2> rigid_sphere_delays_s(double distance_m, double towards_left) {
  const double r = clamped_distance_m(distance_m);
  const double a = kHeadRadius_m;
  std::array<double, 2> delays_s{};
  for (int ear = 0; ear < 2; ++ear) {
    const double cosine = std::clamp(ear == 0 ? towards_left : -towards_left, -1.0, 1.0);
    // Straight, or along the tangent and then around the sphere.
    const double way_m =
        cosine >= a / r ? std::sqrt(r * r + a * a - 2.0 * r * a * cosine)
                        : std::sqrt(r * r - a * a) + a * (std::acos(cosine) - std::acos(a / r));
    delays_s[ear] = (way_m - r) / kSpeedOfSound_m_per_s;
  }
  return delays_s;
}

void near_field_spectra(double distance_m, double measured_distance_m, double towards_left,
                        double nyquist_hz, std::array<std::span<std::complex<float>>, 2> spectra) {
  EARPOINT_CHECK(spectra[0].size() == spectra[1].size() && spectra[0].size() > 1);
  if (distance_m >= measured_distance_m) {
    for (const auto& spectrum : spectra) std::ranges::fill(spectrum, 1.0F);
    return;
  }
  // The ratio changes slowly over frequency: linear interpolation on this grid is within 0.1 %.
  constexpr double kStep_hz = 125.0;
  const int steps = std::max(1, static_cast<int>(std::ceil(nyquist_hz / kStep_hz)));
  const auto ratios = [&](int step) {
    const double frequency_hz = nyquist_hz * step / steps;
    const auto here = rigid_sphere_ears(frequency_hz, distance_m, towards_left);
    const auto there = rigid_sphere_ears(frequency_hz, measured_distance_m, towards_left);
    return std::array<Complex, 2>{here[0] / there[0], here[1] / there[1]};
  };
  // The two points of the grid around a bin are computed when a bin first lies between them.
  int below = 0;
  std::array<Complex, 2> low = ratios(0);
  std::array<Complex, 2> high = ratios(1);
  const std::size_t bins = spectra[0].size();
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double place = static_cast<double>(bin) * steps / static_cast<double>(bins - 1);
    const int wanted = std::min(static_cast<int>(place), steps - 1);
    if (wanted != below) {
      low = wanted == below + 1 ? high : ratios(wanted);
      high = ratios(wanted + 1);
      below = wanted;
    }
    for (int ear = 0; ear < 2; ++ear) {
      spectra[ear][bin] = std::complex<float>(low[ear] + (place - below) * (high[ear] - low[ear]));
    }
  }
}

}  // namespace earpoint

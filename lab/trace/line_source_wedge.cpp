#include "line_source_wedge.h"

#include "complex_angle.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};

constexpr double kSharp =
    8.0;  // the trapezoidal rule misses less than exp(-8) of poles further away

Complex hankel_by_series(Complex z) {
  const Complex square = -z * z / 4.0;
  const Complex log = std::log(z / 2.0) + std::numbers::egamma;
  Complex term = 1.0;
  Complex j = 1.0;
  Complex y = log;
  double harmonic = 0.0;
  for (int k = 1; k < 30; ++k) {
    term *= square / static_cast<double>(k * k);
    harmonic += 1.0 / k;
    j += term;
    y += (log - harmonic) * term;
  }
  return j - kI * (2.0 / kPi) * y;
}

Complex hankel_far_away(Complex z) {
  Complex term = 1.0;
  Complex sum = 1.0;
  for (int k = 1; k < 8; ++k) {
    const double odd = 2.0 * k - 1.0;
    term *= kI * odd * odd / (8.0 * k * z);
    sum += term;
  }
  return std::sqrt(2.0 / (kPi * z)) * std::exp(-kI * (z - kPi / 4.0)) * sum;
}

// Moves a turn of half a circle off the shadow boundary, to the lit side if sound passes.
double off_boundary(double behind_rad, bool passes) {
  if (std::abs(behind_rad) > kOnBoundary_rad) return behind_rad;
  return passes ? kOnBoundary_rad : -kOnBoundary_rad;
}

}  // namespace

Complex hankel(Complex z) {
  constexpr double kFar = 5.0;
  return std::abs(z) < kFar ? hankel_by_series(z) : hankel_far_away(z);
}

Complex line_sound_past_wedge(double open_angle_rad, const EdgePoint& source,
                              const EdgePoint& receiver, const UnbentSound& unbent,
                              double wave_number) {
  const double index = kPi / open_angle_rad;
  const double turn_rad = std::abs(source.angle_rad - receiver.angle_rad);
  const double sum_rad = source.angle_rad + receiver.angle_rad;
  const std::array<double, 4> behind_rad = {
      kPi + turn_rad, off_boundary(kPi - turn_rad, unbent.straight),
      off_boundary(kPi - sum_rad, unbent.mirrored),
      off_boundary(kPi - (2.0 * open_angle_rad - sum_rad), unbent.mirrored)};

  const double squares_m2 =
      source.radius_m * source.radius_m + receiver.radius_m * receiver.radius_m;
  const double product_m2 = 2.0 * source.radius_m * receiver.radius_m;
  const auto wave = [&](const Complex& cosh) {
    return hankel(wave_number * std::sqrt(squares_m2 + product_m2 * cosh));
  };
  const ComplexAngleLine line(wave_number * (source.radius_m + receiver.radius_m));
  const std::vector<Complex> waves = line.sample(wave, 0);
  Complex sum = 0.0;
  for (const double behind : behind_rad) {
    const double half = std::sin(index * behind / 2.0);
    const double sine = std::sin(index * behind);
    Complex power = 1.0;
    const Complex turn = std::exp(index * line.step());
    for (std::size_t i = 0; i < waves.size(); ++i, power *= turn) {
      const Complex cosh_minus_1 = i == 0 ? 0.0 : (power + 1.0 / power) / 2.0 - 1.0;
      sum += (i == 0 ? 1.0 : 2.0) * sine / (cosh_minus_1 + 2.0 * half * half) * waves[i];
    }
  }
  sum *= -index / (4.0 * kPi) * line.step();
  // Poles at +- i times the angle behind a shadow boundary, closer to the line than the rule's
  // steps: their share of its error is known.
  for (const double behind : behind_rad) {
    const Complex decay = 2.0 * kPi * std::abs(behind) / line.step();
    if (decay.real() >= kSharp) continue;
    sum += std::copysign(1.0, behind) / (std::exp(decay) - 1.0) * wave(std::cos(behind));
  }
  return sum;
}

}  // namespace earpoint

#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

namespace earpoint {

/// Points of a line through 0 in the plane of complex angles, turned so that waves die away on it.
/// Integrals along it are taken by the trapezoidal rule, whose error falls exponentially.
class ComplexAngleLine {
 public:
  /// @param longest_phase  of the waves: wave number times the longest way, > 0
  explicit ComplexAngleLine(double longest_phase)
      : step_(std::min(kCoarsestStep, std::sqrt(1.42 / longest_phase)) *
              std::complex<double>(1.0, -kSlope)) {}

  [[nodiscard]] std::complex<double> step() const { return step_; }

  /// @param wave  a function of cosh(angle)
  /// @return  its values at the points from 0 on, until it has died away; `least` or more
  template <typename Wave>
  [[nodiscard]] std::vector<std::complex<double>> sample(const Wave& wave,
                                                         std::size_t least) const {
    std::vector<std::complex<double>> samples;
    const std::complex<double> turn = std::exp(step_);
    for (std::complex<double> power = 1.0;
         step_.real() * static_cast<double>(samples.size()) < kFarthest; power *= turn) {
      samples.push_back(wave((power + 1.0 / power) / 2.0));
      if (samples.size() < least) continue;
      if (std::norm(samples.back()) < kSilent * kSilent * std::norm(samples.front())) break;
    }
    return samples;
  }

 private:
  static constexpr double kSlope = 0.3;
  static constexpr double kCoarsestStep = 0.35;
  static constexpr double kFarthest = 7.0;  // wedges answer with exp(-2/3 of the angle)
  static constexpr double kSilent = 1e-4;   // of what the line begins with

  std::complex<double> step_;
};

}  // namespace earpoint

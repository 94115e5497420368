#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <vector>

namespace earpoint {

/// e^(2 pi i k / count) for any k, from two tables of about sqrt(count) entries: much quicker to
/// build than one sine and cosine per root, and within 2e-16 of them.
class RootsOfUnity {
 public:
  explicit RootsOfUnity(std::int64_t count) : count_(count) {
    while ((std::int64_t{1} << (2 * fine_bits_)) < count) ++fine_bits_;
    const std::int64_t fine_count = std::int64_t{1} << fine_bits_;
    for (std::int64_t k = 0; k < fine_count; ++k) fine_.push_back(root(k));
    for (std::int64_t k = 0; k < count; k += fine_count) coarse_.push_back(root(k));
  }

  [[nodiscard]] std::complex<double> at(std::int64_t k) const {
    if (k < 0 || k >= count_) k = (k % count_ + count_) % count_;
    const std::complex<double> a = coarse_[k >> fine_bits_];
    const std::complex<double> b = fine_[k & ((std::int64_t{1} << fine_bits_) - 1)];
    // Written out: the standard product stops to look for NaN.
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
  }

 private:
  [[nodiscard]] std::complex<double> root(std::int64_t k) const {
    constexpr double kTurn = 6.283185307179586476925286766559;
    const double angle = kTurn * static_cast<double>(k) / static_cast<double>(count_);
    return {std::cos(angle), std::sin(angle)};
  }

  std::int64_t count_;
  int fine_bits_ = 0;
  std::vector<std::complex<double>> fine_;
  std::vector<std::complex<double>> coarse_;
};

}  // namespace earpoint

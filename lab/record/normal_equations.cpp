#include "normal_equations.h"

#include <cmath>

#include <earpoint/error.h>

namespace earpoint {

NormalEquations::NormalEquations(std::size_t size) : size_(size), a_(size * size), b_(size) {}

void NormalEquations::add_prior(std::size_t unknown, double value, double deviation) {
  const double weight = 1.0 / (deviation * deviation);
  a(unknown, unknown) += weight;
  b(unknown) += weight * value;
}

void NormalEquations::fix(std::size_t unknown) {
  for (std::size_t i = 0; i < size_; ++i) a(unknown, i) = a(i, unknown) = 0.0;
  a(unknown, unknown) = 1.0;
  b(unknown) = 0.0;
}

std::vector<double> NormalEquations::factor() const {
  std::vector<double> lower(a_);
  for (std::size_t j = 0; j < size_; ++j) {
    for (std::size_t i = j; i < size_; ++i) {
      double sum = a_[i * size_ + j];
      for (std::size_t k = 0; k < j; ++k) sum -= lower[i * size_ + k] * lower[j * size_ + k];
      if (i == j) {
        EARPOINT_CHECK(sum > 0.0);
        lower[j * size_ + j] = std::sqrt(sum);
      } else {
        lower[i * size_ + j] = sum / lower[j * size_ + j];
      }
    }
  }
  return lower;
}

std::vector<double> NormalEquations::solve_with(std::span<const double> lower,
                                                std::vector<double> right) const {
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t k = 0; k < i; ++k) right[i] -= lower[i * size_ + k] * right[k];
    right[i] /= lower[i * size_ + i];
  }
  for (std::size_t i = size_; i-- > 0;) {
    for (std::size_t k = i + 1; k < size_; ++k) right[i] -= lower[k * size_ + i] * right[k];
    right[i] /= lower[i * size_ + i];
  }
  return right;
}

std::vector<double> NormalEquations::solve() const { return solve_with(factor(), b_); }

std::vector<double> NormalEquations::variances() const {
  const std::vector<double> lower = factor();
  std::vector<double> result(size_);
  for (std::size_t i = 0; i < size_; ++i) {
    std::vector<double> unit(size_);
    unit[i] = 1.0;
    result[i] = solve_with(lower, std::move(unit))[i];
  }
  return result;
}

PlaceEquations::PlaceEquations(std::size_t size) : position_(size, size) {}

void PlaceEquations::add_place_prior(const Vector3& value, const Vector3& deviations) {
  const Row values{value.x, value.y, value.z};
  const Row widths{deviations.x, deviations.y, deviations.z};
  for (std::size_t i = 0; i < 3; ++i) {
    const double weight = 1.0 / (widths[i] * widths[i]);
    place_[i][i] += weight;
    place_right_[i] += weight * values[i];
  }
}

std::size_t PlaceEquations::index_of(std::size_t unknown) {
  if (position_[unknown] < unknowns_.size()) return position_[unknown];
  const std::size_t before = unknowns_.size();
  position_[unknown] = before;
  unknowns_.push_back(unknown);
  std::vector<double> grown((before + 1) * (before + 1));
  for (std::size_t i = 0; i < before; ++i) {
    for (std::size_t j = 0; j < before; ++j) grown[i * (before + 1) + j] = common_[i * before + j];
  }
  common_ = std::move(grown);
  right_.push_back(0.0);
  mixed_.push_back({});
  return before;
}

void PlaceEquations::add(std::span<const ClockTerm> terms, const Vector3& gradient, double residual,
                         double weight) {
  const Row g{gradient.x, gradient.y, gradient.z};
  for (const ClockTerm& term : terms) static_cast<void>(index_of(term.unknown));
  const std::size_t count = unknowns_.size();
  for (const ClockTerm& a : terms) {
    const std::size_t i = position_[a.unknown];
    right_[i] -= weight * a.factor * residual;
    for (std::size_t k = 0; k < 3; ++k) mixed_[i][k] += weight * a.factor * g[k];
    for (const ClockTerm& b : terms) {
      common_[i * count + position_[b.unknown]] += weight * a.factor * b.factor;
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    place_right_[k] -= weight * g[k] * residual;
    for (std::size_t l = 0; l < 3; ++l) place_[k][l] += weight * g[k] * g[l];
  }
}

Vector3 PlaceEquations::solve_place(const Row& right) const {
  const auto vector = [](const Row& row) { return Vector3{row[0], row[1], row[2]}; };
  // Cramer's rule; the matrix is symmetric.
  const Vector3 a = vector(place_[0]);
  const Vector3 b = vector(place_[1]);
  const Vector3 c = vector(place_[2]);
  const Vector3 r = vector(right);
  const double determinant = dot(a, cross(b, c));
  return Vector3{dot(r, cross(b, c)), dot(a, cross(r, c)), dot(a, cross(b, r))} / determinant;
}

void PlaceEquations::eliminate_from(NormalEquations& common) const {
  const std::size_t count = unknowns_.size();
  const Vector3 own = solve_place(place_right_);
  for (std::size_t i = 0; i < count; ++i) {
    const Row& m = mixed_[i];
    const Vector3 solved = solve_place(m);
    common.b(unknowns_[i]) += right_[i] - (m[0] * own.x + m[1] * own.y + m[2] * own.z);
    for (std::size_t j = 0; j < count; ++j) {
      const Row& n = mixed_[j];
      common.a(unknowns_[i], unknowns_[j]) +=
          common_[i * count + j] - (n[0] * solved.x + n[1] * solved.y + n[2] * solved.z);
    }
  }
}

Vector3 PlaceEquations::place_step(std::span<const double> common_step) const {
  Row right = place_right_;
  for (std::size_t i = 0; i < unknowns_.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) right[k] -= mixed_[i][k] * common_step[unknowns_[i]];
  }
  return solve_place(right);
}

}  // namespace earpoint

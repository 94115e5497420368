#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/vector3.h>

namespace earpoint {

/// Normal equations A x = b of a least-squares problem with few unknowns, dense.
class NormalEquations {
 public:
  explicit NormalEquations(std::size_t size);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] double& a(std::size_t row, std::size_t column) { return a_[row * size_ + column]; }
  [[nodiscard]] double& b(std::size_t row) { return b_[row]; }

  /// That unknown is `value`, give or take `deviation`.
  void add_prior(std::size_t unknown, double value, double deviation);
  /// That unknown is 0.
  void fix(std::size_t unknown);

  /// By Cholesky's factors; A must be positive definite.
  [[nodiscard]] std::vector<double> solve() const;
  /// The diagonal of the inverse of A.
  [[nodiscard]] std::vector<double> variances() const;

 private:
  [[nodiscard]] std::vector<double> factor() const;
  [[nodiscard]] std::vector<double> solve_with(std::span<const double> lower,
                                               std::vector<double> right) const;

  std::size_t size_;
  std::vector<double> a_;
  std::vector<double> b_;
};

/// How a residual depends on one of the common unknowns.
struct ClockTerm {
  std::size_t unknown = 0;
  double factor = 0.0;
};

/// The part of a least-squares problem that belongs to one place: three unknowns of its own, which
/// are eliminated before the common unknowns are solved for, and found afterwards.
class PlaceEquations {
 public:
  /// @param size  number of common unknowns
  explicit PlaceEquations(std::size_t size);

  void add_place_prior(const Vector3& value, const Vector3& deviations);
  /// @param terms     derivatives of the residual by common unknowns; one may stand twice
  /// @param gradient  derivative by the place
  void add(std::span<const ClockTerm> terms, const Vector3& gradient, double residual,
           double weight);

  /// Adds what is left of these equations without the place.
  void eliminate_from(NormalEquations& common) const;
  /// The place's step, given that of the common unknowns.
  [[nodiscard]] Vector3 place_step(std::span<const double> common_step) const;

 private:
  using Row = std::array<double, 3>;

  [[nodiscard]] std::size_t index_of(std::size_t unknown);
  [[nodiscard]] Vector3 solve_place(const Row& right) const;

  std::vector<std::size_t> unknowns_;  ///< the common ones that appear, few of all
  std::vector<std::size_t> position_;  ///< in unknowns_, by unknown; size: not there
  std::vector<double> common_;         ///< [unknown][unknown], grown as they appear
  std::vector<double> right_;
  std::vector<Row> mixed_;  ///< common by place
  std::array<Row, 3> place_{};
  Row place_right_{};
};

}  // namespace earpoint

#pragma once

#include <cstdint>

namespace earpoint {

/// Smooth noise on the unit square that repeats without a seam, in [0, 1].
class PeriodicNoise {
 public:
  explicit PeriodicNoise(std::uint64_t seed) : seed_(seed) {}

  /// @return a fixed random number for a cell of a lattice, uniform in [0, 1)
  [[nodiscard]] double cell(int x, int y) const;

  /// @param cells_u, cells_v  lattice cells along u and v, > 0
  [[nodiscard]] double smooth(double u, double v, int cells_u, int cells_v) const;

  /// Sums `octaves` of smooth noise, each twice as fine and half as strong.
  [[nodiscard]] double fractal(double u, double v, int cells_u, int cells_v, int octaves) const;

 private:
  std::uint64_t seed_;
};

}  // namespace earpoint

#include "noise.h"

#include <cmath>

namespace earpoint {
namespace {

int wrapped(int value, int period) {
  const int rest = value % period;
  return rest < 0 ? rest + period : rest;
}

double eased(double t) { return t * t * (3.0 - 2.0 * t); }

}  // namespace

double PeriodicNoise::cell(int x, int y) const {
  // splitmix64's finalizer over the three numbers.
  std::uint64_t h = seed_ + 0x9E3779B97F4A7C15ULL * static_cast<std::uint32_t>(x) +
                    0xC2B2AE3D27D4EB4FULL * static_cast<std::uint32_t>(y);
  h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ULL;
  h = (h ^ (h >> 27)) * 0x94D049BB133111EBULL;
  h ^= h >> 31;
  return static_cast<double>(h >> 11) * 0x1.0p-53;
}

double PeriodicNoise::smooth(double u, double v, int cells_u, int cells_v) const {
  const double x = u * cells_u;
  const double y = v * cells_v;
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  const double fx = eased(x - x0);
  const double fy = eased(y - y0);
  const auto at = [&](int i, int j) {
    return cell(wrapped(i, cells_u), wrapped(j, cells_v) + 7919 * cells_v);
  };
  const double low = at(x0, y0) + (at(x0 + 1, y0) - at(x0, y0)) * fx;
  const double high = at(x0, y0 + 1) + (at(x0 + 1, y0 + 1) - at(x0, y0 + 1)) * fx;
  return low + (high - low) * fy;
}

double PeriodicNoise::fractal(double u, double v, int cells_u, int cells_v, int octaves) const {
  double sum = 0.0;
  double weight = 0.0;
  double strength = 1.0;
  for (int i = 0; i < octaves; ++i) {
    sum += strength * smooth(u, v, cells_u << i, cells_v << i);
    weight += strength;
    strength /= 2.0;
  }
  return sum / weight;
}

}  // namespace earpoint

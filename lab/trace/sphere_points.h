#pragma once

#include <algorithm>
#include <cmath>

#include <earpoint/pose.h>

namespace earpoint {

/// A direction out of `count` that cover the sphere evenly: points of a spiral.
/// @param point   in [0, count)
/// @param within  where in its ring of equal area, in [0, 1]; 0.5 for its middle
/// @param turn_rad  turns the spiral about z
inline Vector3 spiral_direction(int point, double within, int count, double turn_rad) {
  const double golden_angle_rad = kPi * (3.0 - std::sqrt(5.0));
  const double z = 1.0 - 2.0 * (point + within) / count;
  const double across = std::sqrt(std::max(0.0, 1.0 - z * z));
  const double azimuth_rad = golden_angle_rad * point + turn_rad;
  return {across * std::cos(azimuth_rad), across * std::sin(azimuth_rad), z};
}

}  // namespace earpoint

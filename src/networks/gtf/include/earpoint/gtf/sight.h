#pragma once

#include <array>
#include <span>

#include <earpoint/vector3.h>

namespace earpoint {

/// A place in the square view of gtf_view(), and how a map of its pixels is read there.
struct GtfSight {
  bool is_seen = false;  ///< else the rest means nothing
  /// Row * side + column of the four pixels around it.
  std::array<int, 4> pixels{};
  std::array<float, 4> weights{};  ///< of bilinear interpolation; their sum is 1
};

/// Where the view shows the straight way from the camera to a target: half of the points stand on
/// the way, at even steps up to the target itself, and half on the floor below them, which is taken
/// to lie 1.5 m below the camera. A floor that ends before the target tells of a wall.
/// @param target_m  in the camera's frame
/// @param side      of the map, pixels; it covers the 90 degrees of the view
/// @param points    those on the way first, nearest first; an even number
void find_sights(const Vector3& target_m, int side, std::span<GtfSight> points);

}  // namespace earpoint

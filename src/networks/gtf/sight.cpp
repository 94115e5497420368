#include <earpoint/gtf/sight.h>

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kEyeHeight_m = 1.5;
/// Points that are nearer than this in front of the camera, or behind it, are not seen.
constexpr double kNearest_m = 0.1;

/// One axis of a map: the two pixels around a place, and the share of the second.
struct Between {
  int first = 0;
  int second = 0;
  float share = 0.0F;
};

/// @param place  0 to 1 across the map
Between between(double place, int side) {
  const double at = std::clamp(place * side - 0.5, 0.0, side - 1.0);
  const int first = static_cast<int>(at);
  return {first, std::min(first + 1, side - 1), static_cast<float>(at - first)};
}

GtfSight sight_of(const Vector3& point_m, int side) {
  GtfSight sight;
  if (point_m.x < kNearest_m) return sight;
  // The view is 90 degrees across: 1 to either side at a distance of 1.
  const double across = 0.5 - 0.5 * point_m.y / point_m.x;
  const double down = 0.5 - 0.5 * point_m.z / point_m.x;
  if (across < 0.0 || across > 1.0 || down < 0.0 || down > 1.0) return sight;
  const Between column = between(across, side);
  const Between row = between(down, side);
  sight.is_seen = true;
  sight.pixels = {row.first * side + column.first, row.first * side + column.second,
                  row.second * side + column.first, row.second * side + column.second};
  sight.weights = {(1.0F - row.share) * (1.0F - column.share), (1.0F - row.share) * column.share,
                   row.share * (1.0F - column.share), row.share * column.share};
  return sight;
}

}  // namespace

void find_sights(const Vector3& target_m, int side, std::span<GtfSight> points) {
  EARPOINT_CHECK(side > 0 && points.size() % 2 == 0);
  const std::size_t steps = points.size() / 2;
  for (std::size_t i = 0; i < steps; ++i) {
    const Vector3 on_the_way = target_m * (static_cast<double>(i + 1) / static_cast<double>(steps));
    points[i] = sight_of(on_the_way, side);
    points[steps + i] = sight_of({on_the_way.x, on_the_way.y, -kEyeHeight_m}, side);
  }
}

}  // namespace earpoint

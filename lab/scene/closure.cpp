#include <earpoint/scene/closure.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>
#include <earpoint/scene/ray_caster.h>

namespace earpoint {
namespace {

constexpr int kPlaces = 64;
constexpr int kPlaceTries = 4000;
constexpr int kRaysPerPlace = 128;
constexpr double kWeld_m = 1e-4;
constexpr double kSteep = 0.5;  ///< the sine of 30 degrees

Vector3 random_direction(RandomStream& random) {
  const double z = random.uniform(-1.0, 1.0);
  const double azimuth_rad = random.uniform(0.0, 2.0 * kPi);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(azimuth_rad), r * std::sin(azimuth_rad), z};
}

/// Whether the place has a floor below and walls on at least three of four sides.
bool is_inside(const RayCaster& caster, const Vector3& place) {
  if (!caster.distance_m(place, {0, 0, -1})) return false;
  int walls = 0;
  for (const Vector3& side :
       {Vector3{1, 0, 0}, Vector3{-1, 0, 0}, Vector3{0, 1, 0}, Vector3{0, -1, 0}}) {
    if (caster.distance_m(place, side)) ++walls;
  }
  return walls >= 3;
}

void count_escaping_rays(const Scene& scene, RandomStream& random, Closure& closure) {
  const RayCaster caster(scene.mesh);
  const Bounds box = bounds(scene.mesh);
  std::size_t escaped = 0;
  std::size_t escaped_up = 0;
  int places = 0;
  for (int i = 0; i < kPlaceTries && places < kPlaces; ++i) {
    const Vector3 place{random.uniform(box.low.x, box.high.x),
                        random.uniform(box.low.y, box.high.y),
                        random.uniform(box.low.z, box.high.z)};
    if (!is_inside(caster, place)) continue;
    ++places;
    for (int j = 0; j < kRaysPerPlace; ++j) {
      const Vector3 direction = random_direction(random);
      ++closure.rays;
      if (caster.distance_m(place, direction)) continue;
      ++escaped;
      if (direction.z > kSteep) ++escaped_up;
    }
  }
  if (closure.rays == 0) return;
  closure.escaping_share = static_cast<double>(escaped) / static_cast<double>(closure.rays);
  closure.escaping_up_share = static_cast<double>(escaped_up) / static_cast<double>(closure.rays);
}

/// @return for every vertex the index of the first one at the same place
std::vector<std::uint32_t> welded(const Mesh& mesh) {
  using Cell = std::array<std::int64_t, 3>;
  std::map<Cell, std::uint32_t> first;
  std::vector<std::uint32_t> place(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    Cell cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell[axis] = std::llround(static_cast<double>(mesh.positions[i][axis]) / kWeld_m);
    }
    place[i] = first.try_emplace(cell, static_cast<std::uint32_t>(i)).first->second;
  }
  return place;
}

void count_open_edges(const Mesh& mesh, Closure& closure) {
  const std::vector<std::uint32_t> place = welded(mesh);
  std::unordered_map<std::uint64_t, int> faces_at;
  const auto for_each_edge = [&](auto&& visit) {
    for (const auto& triangle : mesh.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = place[triangle[i]];
        const std::uint32_t b = place[triangle[(i + 1) % 3]];
        if (a == b) continue;
        visit(a, b, (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b));
      }
    }
  };
  for_each_edge([&](std::uint32_t, std::uint32_t, std::uint64_t key) { ++faces_at[key]; });
  for_each_edge([&](std::uint32_t a, std::uint32_t b, std::uint64_t key) {
    if (faces_at[key] != 1) return;
    ++closure.open_edges;
    closure.open_edges_m += norm(vertex(mesh, a) - vertex(mesh, b));
  });
}

}  // namespace

Closure check_closure(const Scene& scene, std::uint64_t seed) {
  Closure closure;
  RandomStream random(seed);
  count_escaping_rays(scene, random, closure);
  count_open_edges(scene.mesh, closure);
  return closure;
}

}  // namespace earpoint

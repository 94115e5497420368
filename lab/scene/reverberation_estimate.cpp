#include <earpoint/scene/reverberation_estimate.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace earpoint {
namespace {

/// 24 ln(10) / c at 20 degrees, s/m.
constexpr double kSabine = 0.161;

std::size_t nearest_room(const FloorPlan& plan, double x, double y) {
  std::size_t best = 0;
  double best_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    const FloorRectangle& r = plan.rooms[i].floor;
    const double off_m = std::hypot(std::max({r.x_min - x, x - r.x_max, 0.0}),
                                    std::max({r.y_min - y, y - r.y_max, 0.0}));
    if (off_m >= best_m) continue;
    best_m = off_m;
    best = i;
  }
  return best;
}

}  // namespace

std::vector<ReverberationEstimate> estimate_reverberation(const Home& home) {
  const Mesh& mesh = home.scene.mesh;
  std::vector<ReverberationEstimate> rooms(home.plan.rooms.size());
  std::vector<std::array<double, kOctaveBands>> absorbed_m2(rooms.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Vector3 middle = (vertex(mesh, a) + vertex(mesh, b) + vertex(mesh, c)) / 3.0;
    const std::size_t room = nearest_room(home.plan, middle.x, middle.y);
    const double area_m2 = norm(scaled_normal(mesh, i)) / 2.0;
    rooms[room].surface_m2 += area_m2;
    const Material& material = home.scene.materials[mesh.triangle_material[i]];
    for (std::size_t band = 0; band < kOctaveBands; ++band) {
      absorbed_m2[room][band] += area_m2 * material.acoustic.absorption[band];
    }
  }
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    ReverberationEstimate& room = rooms[i];
    room.volume_m3 = home.plan.rooms[i].floor.area_m2() * home.plan.rooms[i].ceiling_m;
    for (std::size_t band = 0; band < kOctaveBands; ++band) {
      const double mean = absorbed_m2[i][band] / room.surface_m2;
      room.absorption[band] = static_cast<float>(mean);
      room.sabine_s[band] = kSabine * room.volume_m3 / absorbed_m2[i][band];
      room.eyring_s[band] = kSabine * room.volume_m3 / (-room.surface_m2 * std::log1p(-mean));
    }
  }
  return rooms;
}

}  // namespace earpoint

#include <earpoint/scene/mesh.h>

#include <algorithm>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {

Bounds bounds(const Mesh& mesh) {
  if (mesh.positions.empty()) return {};
  Bounds box{vertex(mesh, 0), vertex(mesh, 0)};
  for (const auto& [x, y, z] : mesh.positions) {
    box.low = {std::min<double>(box.low.x, x), std::min<double>(box.low.y, y),
               std::min<double>(box.low.z, z)};
    box.high = {std::max<double>(box.high.x, x), std::max<double>(box.high.y, y),
                std::max<double>(box.high.z, z)};
  }
  return box;
}

Vector3 scaled_normal(const Mesh& mesh, std::size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return cross(vertex(mesh, b) - vertex(mesh, a), vertex(mesh, c) - vertex(mesh, a));
}

void check_inside(std::string_view where, const Vector3& position, const Bounds& box) {
  const auto is_between = [](double value, double low, double high) {
    return value > low && value < high;
  };
  if (is_between(position.x, box.low.x, box.high.x) &&
      is_between(position.y, box.low.y, box.high.y) &&
      is_between(position.z, box.low.z, box.high.z)) {
    return;
  }
  // Enough digits for coordinates of a land survey.
  throw InputError(
      where,
      fmt::format("({:.10g}, {:.10g}, {:.10g}) is outside the scene, which spans x {:.9g} to "
                  "{:.9g}, y {:.9g} to {:.9g}, z {:.9g} to {:.9g} m",
                  position.x, position.y, position.z, box.low.x, box.high.x, box.low.y, box.high.y,
                  box.low.z, box.high.z),
      "place it inside");
}

}  // namespace earpoint

#include <earpoint/scene/mesh.h>

#include <algorithm>

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

}  // namespace earpoint

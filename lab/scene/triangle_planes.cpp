#include <earpoint/scene/triangle_planes.h>

#include <algorithm>

namespace earpoint {

TrianglePlanes::TrianglePlanes(const Mesh& mesh) {
  planes_.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vector3 scaled = scaled_normal(mesh, i);
    const double length = norm(scaled);
    const Vector3 normal = length > 0.0 ? scaled / length : Vector3{};
    const auto& [a, b, c] = mesh.triangles[i];
    const Vector3 middle = (vertex(mesh, a) + vertex(mesh, b) + vertex(mesh, c)) / 3.0;
    double radius_m = 0.0;
    for (const std::uint32_t corner : {a, b, c}) {
      radius_m = std::max(radius_m, norm(vertex(mesh, corner) - middle));
    }
    planes_.push_back({{normal.x, normal.y, normal.z},
                       dot(normal, vertex(mesh, a)),
                       {middle.x, middle.y, middle.z},
                       radius_m});
  }
}

}  // namespace earpoint

#include <earpoint/scene/triangle_planes.h>

namespace earpoint {

TrianglePlanes::TrianglePlanes(const Mesh& mesh) {
  planes_.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vector3 scaled = scaled_normal(mesh, i);
    const double length = norm(scaled);
    const Vector3 normal = length > 0.0 ? scaled / length : Vector3{};
    planes_.push_back(
        {{normal.x, normal.y, normal.z}, dot(normal, vertex(mesh, mesh.triangles[i][0]))});
  }
}

}  // namespace earpoint

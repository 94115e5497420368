#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include <earpoint/vector3.h>

namespace earpoint {

/// Triangles in memory, metres, z up. Faces are two-sided for sound.
struct Mesh {
  std::vector<std::array<float, 3>> positions;          ///< [vertices]
  std::vector<std::array<float, 3>> normals;            ///< [vertices], or empty
  std::vector<std::array<float, 2>> uvs;                ///< [vertices], or empty; v points up
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< [triangles], indices into positions
  std::vector<std::uint32_t> triangle_material;         ///< [triangles], into `Scene::materials`
  std::vector<std::uint32_t> triangle_instance;         ///< [triangles], into `Scene::instances`
};

/// An axis-aligned box.
struct Bounds {
  Vector3 low;
  Vector3 high;
};

/// @return the box around all positions; all zero for an empty mesh
Bounds bounds(const Mesh& mesh);

/// @param where     what is placed, for messages
/// @param position  metres, as the box is
/// @throws InputError if it is not inside the box
void check_inside(std::string_view where, const Vector3& position, const Bounds& box);

/// @return the position of a vertex
inline Vector3 vertex(const Mesh& mesh, std::uint32_t index) {
  const std::array<float, 3>& p = mesh.positions[index];
  return {p[0], p[1], p[2]};
}

/// @return twice the area of a triangle times its normal (counter-clockwise is outside)
Vector3 scaled_normal(const Mesh& mesh, std::size_t triangle);

}  // namespace earpoint

#pragma once

#include <vector>

#include <earpoint/scene/scene.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// A straight stretch along which the mesh has a crease or ends.
struct Crease {
  Vector3 begin_m;
  Vector3 end_m;
};

/// Finds the creases of a mesh: pairs of triangles that meet at an angle, and borders. Collinear
/// ones that touch are joined. Vertices within a millimetre are one.
/// @param shortest_m     of a joined crease
/// @param counts         [instances], whether an instance's triangles take part
std::vector<Crease> find_creases(const Mesh& mesh, const std::vector<bool>& counts,
                                 double shortest_m);

}  // namespace earpoint

#pragma once

#include <cstddef>

#include <earpoint/scene/mesh.h>

namespace earpoint {

/// Drops faces between the same three corners as an earlier one: models often draw cloth twice,
/// once for each side, which hides its hems from simplify(). All our faces have two sides.
/// @return how many were dropped
std::size_t drop_doubled_faces(Mesh& mesh);

/// Joins vertices that are alike in position, normal and texture coordinates, and drops those that
/// no triangle uses.
void join_vertices(Mesh& mesh);

/// Takes triangles away where it shows least, each material on its own, until at most
/// `most_triangles` are left, or a tenth of the size is the price. The borders of materials and
/// open edges stay as they are if that is possible.
/// Source: Garland and Heckbert, SIGGRAPH 1997 (quadric errors), as in meshoptimizer.
/// @param mesh  with vertices joined
void simplify(Mesh& mesh, std::size_t most_triangles);

}  // namespace earpoint

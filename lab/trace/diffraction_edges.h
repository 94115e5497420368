#pragma once

#include "edge_pair_diffraction.h"
#include "triangle_tree.h"
#include "wedge_diffraction.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/vector3.h>

namespace earpoint {

class SceneGeometry;

/// A straight edge that sound bends round: a door frame, the end of a wall, the rim of a wardrobe.
struct DiffractionEdge {
  Vector3 origin_m;    ///< z = 0 of the edge's coordinates
  Vector3 direction;   ///< unit vector along the edge
  Vector3 first_face;  ///< unit vector from the edge into its first face
  Vector3 into_air;    ///< unit vector across the edge, turned from `first_face` by 90 degrees into
                       ///< the air
  double length_m = 0.0;
  Wedge wedge;
  std::array<std::uint32_t, 2> face_triangles{};  ///< one of either face, index into the mesh
};

/// @return a point in an edge's coordinates
EdgePoint edge_point(const DiffractionEdge& edge, const Vector3& point);

/// @return a point on an edge, moved by `clearance_m` into the middle of its air
Vector3 point_on_edge(const DiffractionEdge& edge, double z_m, double clearance_m);

/// Two parallel edges with a face between them: the end of a thick wall, the reveal of a door.
struct EdgePair {
  std::array<std::size_t, 2> edges{};
  EdgeFace face;
  std::array<double, 2> face_angle_rad{};  ///< of the face, around either edge: 0 or its open angle
  std::uint32_t face_triangle = 0;         ///< one of the face, index into the mesh
  double z_offset_m = 0.0;                 ///< of the second edge's origin, along the first edge
  double z_sign = 1.0;                     ///< -1 if the second edge runs the other way

  /// @param which  0 or 1: the edge that z belongs to
  /// @return the same place along the other edge
  [[nodiscard]] double opposite_z(int which, double z) const {
    return which == 0 ? z_sign * (z - z_offset_m) : z_offset_m + z_sign * z;
  }
};

/// @return every pair once
std::vector<EdgePair> find_edge_pairs(std::span<const DiffractionEdge> edges);

/// Edges that share faces, with those faces: their sound is one wave.
struct EdgeGroup {
  std::vector<std::size_t> edges;
  std::vector<std::size_t> pairs;
};

/// @return every edge in one group, most of them alone
std::vector<EdgeGroup> group_edges(std::size_t edge_count, std::span<const EdgePair> pairs);

/// Finds the edges of a mesh that are long enough and open enough to matter: creases of walls and
/// doors from 0.4 m on, of furniture from 1 m on (shorter ones scatter, which the materials'
/// scattering stands for), where the air opens by 20 degrees or more beyond flat. People have none.
/// Whether faces meet at an edge is not asked of the mesh's indices but of rays on small circles
/// around it: parts that touch without sharing vertices, or stand in one another, count as they
/// lie.
std::vector<DiffractionEdge> find_diffraction_edges(const SceneGeometry& scene);

}  // namespace earpoint

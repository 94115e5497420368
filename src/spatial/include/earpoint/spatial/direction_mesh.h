#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/vector3.h>

namespace earpoint {

/// Directions on the sphere joined to triangles, to interpolate between what was measured there.
///
/// The triangles are the faces of the directions' convex hull (a spherical Delaunay
/// triangulation). The weights are those with which the corners' unit vectors add up to the
/// direction, scaled to the sum one: they are continuous across triangles and single out a corner
/// when the direction hits it. Where directions lie on rings, quadrangles are split in a way that
/// is mirror-symmetric in y, as heads are.
class DirectionMesh {
 public:
  /// Corner indices into the given directions, and weights >= 0 that sum to one.
  struct Place {
    std::array<int, 3> corners{};
    std::array<double, 3> weights{};
  };

  /// @param directions  unit vectors, at least 4, no two closer than 0.01 degrees
  /// @throws std::logic_error if there are too few or all lie in one plane
  explicit DirectionMesh(std::span<const Vector3> directions);

  /// @return whether a mesh can be made of these: at least 4, not all in one plane
  [[nodiscard]] static bool spans_space(std::span<const Vector3> directions);

  /// The triangle around a direction. If none is (the directions leave a hemisphere empty), the
  /// nearest corner alone, with weight one.
  /// @param direction  not zero; need not be of unit length
  /// Cost: a short walk over the triangles. Allocates nothing; safe from several threads.
  [[nodiscard]] Place locate(const Vector3& direction) const;

  /// @return the index of the nearest direction by angle. Cost: as locate.
  [[nodiscard]] int nearest(const Vector3& direction) const;

  [[nodiscard]] std::size_t triangles() const { return triangles_.size(); }

 private:
  struct Triangle {
    std::array<int, 3> corners{};     // counter-clockwise seen from outside
    std::array<int, 3> neighbours{};  // across the edge opposite to each corner
    std::array<Vector3, 3> inverse;   // rows: the weights of a direction are its dot products
  };
  struct Face;

  static std::vector<Face> hull(std::span<const Vector3> points);
  [[nodiscard]] std::array<double, 3> weights(const Triangle& triangle, const Vector3& v) const;
  [[nodiscard]] int start(const Vector3& unit) const;
  [[nodiscard]] int find(const Vector3& unit) const;
  void join();

  std::vector<Vector3> directions_;
  std::vector<Triangle> triangles_;
  std::vector<int> starts_;        // a triangle near each cell of a coarse grid
  std::vector<int> joined_;        // directions that share an edge, one list after the other
  std::vector<int> joined_begin_;  // where each direction's list begins in joined_
};

}  // namespace earpoint

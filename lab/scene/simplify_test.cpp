#include "simplify.h"

#include <algorithm>
#include <cstdint>

#include <gtest/gtest.h>

namespace earpoint {
namespace {

/// A bumpy cloth of n x n squares over [0, 1] x [0, 1], twice: one for each side.
Mesh doubled_cloth(std::uint32_t n) {
  Mesh mesh;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      const float bump = (i + j) % 2 == 0 ? 0.001F : 0.0F;
      mesh.positions.push_back({static_cast<float>(i) / static_cast<float>(n),
                                static_cast<float>(j) / static_cast<float>(n), bump});
      mesh.normals.push_back({0.0F, 0.0F, 1.0F});
      mesh.uvs.push_back({0.0F, 0.0F});
    }
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
      mesh.triangles.push_back({a, a + n + 2, a + 1});
      mesh.triangles.push_back({a, a + n + 1, a + n + 2});
    }
  }
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  mesh.triangle_instance.assign(mesh.triangles.size(), 0);
  return mesh;
}

double area_m2(const Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) sum += norm(scaled_normal(mesh, i)) / 2.0;
  return sum;
}

TEST(DropDoubledFaces, KeepsOneOfTwoFacesBackToBack) {
  Mesh mesh = doubled_cloth(8);
  EXPECT_EQ(drop_doubled_faces(mesh), 128U);
  EXPECT_EQ(mesh.triangles.size(), 128U);
  EXPECT_EQ(mesh.triangle_material.size(), 128U);
  EXPECT_EQ(mesh.triangle_instance.size(), 128U);
  EXPECT_EQ(drop_doubled_faces(mesh), 0U);
}

TEST(Simplify, KeepsTheHemOfClothThatWasDrawnTwice) {
  Mesh mesh = doubled_cloth(32);
  const double whole_m2 = area_m2(mesh) / 2.0;
  drop_doubled_faces(mesh);
  join_vertices(mesh);
  simplify(mesh, 400);
  EXPECT_LE(mesh.triangles.size(), 400U);
  // The removed bumps had 2 % more area than the plane; a damaged border would lose more than that.
  EXPECT_NEAR(area_m2(mesh), whole_m2, 0.02 * whole_m2);
  const Bounds box = bounds(mesh);
  EXPECT_EQ(box.low.x, 0.0);
  EXPECT_EQ(box.high.x, 1.0);
}

}  // namespace
}  // namespace earpoint

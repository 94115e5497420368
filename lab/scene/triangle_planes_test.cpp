#include <gtest/gtest.h>

#include <earpoint/scene/triangle_planes.h>

namespace earpoint {
namespace {

Mesh slanted() {
  Mesh mesh;
  mesh.positions = {{0, 0, 1}, {2, 0, 2}, {0, 2, 1}, {5, 5, 5}, {5, 5, 5}, {6, 6, 6}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  return mesh;
}

TEST(TrianglePlanes, FindWhereARayMeetsAPlane) {
  const TrianglePlanes planes(slanted());
  // z = 1 + x / 2 straight above (0.5, 0.5).
  EXPECT_EQ(planes.distance(0, {0.5F, 0.5F, 0.0F}, {0, 0, 1}), 1.25F);
  // The distance is in lengths of the direction.
  EXPECT_EQ(planes.distance(0, {0.5F, 0.5F, 0.0F}, {0, 0, 0.5F}), 2.5F);
}

TEST(TrianglePlanes, StayAtATriangleWhosePlaneDoesNotTell) {
  const TrianglePlanes planes(slanted());
  // A ray along the plane gets the triangle's middle, (2/3, 2/3, 4/3), projected on the direction
  // of length sqrt(5).
  EXPECT_NEAR(planes.distance(0, {0, 0, 1}, {2, 0, 1}), (2.0 / 3.0 * 2.0 + 1.0 / 3.0) / 5.0,
              1e-7);  // single precision
  // A ray so nearly parallel that the plane alone would be far beyond the triangle.
  const float far = planes.distance(0, {0, 0, 1.0F - 1e-4F}, {2, 0, 1.0F + 1e-7F});
  EXPECT_GT(far, 0.0F);
  EXPECT_LT(far, 1.5F);
  // A triangle without area gives its middle, (16/3, 16/3, 16/3).
  EXPECT_NEAR(planes.distance(1, {0, 0, 0}, {1, 1, 1}), 16.0 / 3.0, 1e-6);  // single precision
}

}  // namespace
}  // namespace earpoint

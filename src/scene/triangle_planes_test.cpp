#include <cmath>

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
  EXPECT_EQ(planes.distance(0, {0.5F, 0.5F, 0.0F}, {0, 0, 1}, 1.2501F), 1.25F);
  // In units of the direction.
  EXPECT_EQ(planes.distance(0, {0.5F, 0.5F, 0.0F}, {0, 0, 0.5F}, 2.5001F), 2.5F);
}

TEST(TrianglePlanes, KeepAnEstimateThatThePlaneDoesNotTellBetter) {
  const TrianglePlanes planes(slanted());
  // Along the plane, and a triangle without area.
  EXPECT_EQ(planes.distance(0, {0, 0, 1}, {2, 0, 1}, 0.7F), 0.7F);
  EXPECT_EQ(planes.distance(1, {0, 0, 0}, {1, 1, 1}, 0.7F), 0.7F);
}

TEST(TrianglePlanes, GiveTheSameBitsWhateverTheEstimatesLastOnes) {
  const TrianglePlanes planes(slanted());
  const float right = planes.distance(0, {0.1F, 0.3F, -7.7F}, {0.1F, 0.2F, 0.97F}, 9.51F);
  for (int bits = -8; bits <= 8; ++bits) {
    float estimate = right;
    for (int i = 0; i < std::abs(bits); ++i) {
      estimate = std::nextafter(estimate, bits < 0 ? 0.0F : 100.0F);
    }
    EXPECT_EQ(planes.distance(0, {0.1F, 0.3F, -7.7F}, {0.1F, 0.2F, 0.97F}, estimate), right);
  }
}

}  // namespace
}  // namespace earpoint

#include "polygon.h"

#include <gtest/gtest.h>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

/// The sum of the triangles' areas, and of their vectors.
std::pair<double, Vector3> areas(const std::vector<Vector3>& corners) {
  double sum = 0.0;
  Vector3 vector;
  for (const auto& [a, b, c] : triangulate(corners)) {
    const Vector3 normal = cross(corners[b] - corners[a], corners[c] - corners[a]) / 2.0;
    sum += norm(normal);
    vector = vector + normal;
  }
  return {sum, vector};
}

const std::vector<Vector3> kL = {{0, 0, 0}, {6, 0, 0}, {6, 2, 0}, {3, 2, 0}, {3, 4, 0}, {0, 4, 0}};

TEST(Triangulate, CoversAnAngledPolygonOnce) {
  const auto [area, vector] = areas(kL);
  EXPECT_EQ(triangulate(kL).size(), 4U);
  EXPECT_NEAR(area, 18.0, 1e-12);  // rounding of doubles
  EXPECT_NEAR(vector.z, 18.0, 1e-12);
}

TEST(Triangulate, KeepsTheTurnFromAnyStartInAnyPlane) {
  const Quaternion tilt = normalized(Quaternion{0.3, 0.5, -0.7, 0.2});
  for (std::size_t start = 0; start < kL.size(); ++start) {
    for (const bool reversed : {false, true}) {
      std::vector<Vector3> corners;
      for (std::size_t i = 0; i < kL.size(); ++i) {
        corners.push_back(rotate(tilt, kL[(start + i) % kL.size()]) + Vector3{5, -3, 2});
      }
      if (reversed) std::reverse(corners.begin(), corners.end());
      const auto [area, vector] = areas(corners);
      EXPECT_NEAR(area, 18.0, 1e-9);
      EXPECT_NEAR(norm(vector), 18.0, 1e-9) << "triangles overlap";
      const Vector3 up = rotate(tilt, {0, 0, reversed ? -18.0 : 18.0});
      EXPECT_NEAR(norm(vector - up), 0.0, 1e-9);
    }
  }
}

TEST(Triangulate, CoversAComb) {
  std::vector<Vector3> comb = {{0, 0, 0}, {10, 0, 0}};
  double expected = 10.0;
  for (int tooth = 9; tooth >= 0; --tooth) {
    comb.push_back({tooth + 1.0, 5, 0});
    comb.push_back({tooth + 0.5, 5, 0});
    comb.push_back({tooth + 0.5, 1, 0});
    comb.push_back({tooth + 0.0, 1, 0});
    expected += 2.0;
  }
  const auto [area, vector] = areas(comb);
  EXPECT_NEAR(area, expected, 1e-9);
  EXPECT_NEAR(vector.z, expected, 1e-9);
}

TEST(Triangulate, EndsOnCrookedInput) {
  EXPECT_TRUE(triangulate({}).empty());
  EXPECT_TRUE(triangulate({{0, 0, 0}, {1, 0, 0}}).empty());
  EXPECT_EQ(triangulate({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {1, 0, 0}}).size(), 3U);
  EXPECT_EQ(triangulate({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).size(), 2U) << "a bow tie";
  EXPECT_EQ(triangulate(std::vector<Vector3>(7)).size(), 5U) << "all in one place";
}

}  // namespace
}  // namespace earpoint

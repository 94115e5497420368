#include <array>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/gtf/sight.h>

namespace earpoint {
namespace {

constexpr int kSide = 16;

/// Row and column at which a sight point reads the map, in pixels from its corner.
std::array<double, 2> read_at(const GtfSight& sight) {
  std::array<double, 2> at{};
  for (std::size_t i = 0; i < 4; ++i) {
    at[0] += sight.weights[i] * (sight.pixels[i] / kSide + 0.5);
    at[1] += sight.weights[i] * (sight.pixels[i] % kSide + 0.5);
  }
  return at;
}

TEST(GtfSight, PointsOfTheWayAndOfTheFloorLieWhereAPinholeCameraShowsThem) {
  std::vector<GtfSight> points(8);
  find_sights({4.0, 2.0, 0.4}, kSide, points);
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(points[i].is_seen) << i;
    // All points of the way lie in one direction: y / x = 1/2, z / x = 1/10.
    // Single precision: some roundings of up to 16 pixels.
    EXPECT_NEAR(read_at(points[i])[0], 8.0 - 0.8, 1e-5) << i;
    EXPECT_NEAR(read_at(points[i])[1], 8.0 - 4.0, 1e-5) << i;
    // The floor 1 m ahead is below the picture; at x metres it is 1.5 / x below the middle.
    const double x_m = i + 1.0;
    ASSERT_EQ(points[4 + i].is_seen, i > 0) << i;
    if (i == 0) continue;
    EXPECT_NEAR(read_at(points[4 + i])[0], 8.0 + 8.0 * 1.5 / x_m, 1e-5) << i;
    EXPECT_NEAR(read_at(points[4 + i])[1], 8.0 - 4.0, 1e-5) << i;
  }
}

TEST(GtfSight, WhatIsBehindOrBesideTheCameraIsNotSeen) {
  std::vector<GtfSight> points(4);
  for (const Vector3& target_m :
       {Vector3{-3, 0.1, 0}, Vector3{0, 0, 0}, Vector3{2, 2.1, 0}, Vector3{2, -2.1, 0}}) {
    find_sights(target_m, kSide, points);
    for (const GtfSight& point : points) EXPECT_FALSE(point.is_seen);
  }
}

TEST(GtfSight, AtTheEdgeTheOutermostPixelsAreRead) {
  std::vector<GtfSight> points(2);
  find_sights({2, 2, 0}, kSide, points);
  ASSERT_TRUE(points[0].is_seen);
  EXPECT_NEAR(read_at(points[0])[1], 0.5, 1e-6);
  for (const GtfSight& point : points) {
    EXPECT_NEAR(std::accumulate(point.weights.begin(), point.weights.end(), 0.0), 1.0, 1e-6);
    for (const int pixel : point.pixels) {
      EXPECT_GE(pixel, 0);
      EXPECT_LT(pixel, kSide * kSide);
    }
  }
}

}  // namespace
}  // namespace earpoint

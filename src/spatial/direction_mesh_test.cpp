#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/direction_mesh.h>

namespace earpoint {
namespace {

Vector3 direction(double azimuth_deg, double elevation_deg) {
  return cartesian_from_spherical(
      {radians_from_degrees(azimuth_deg), radians_from_degrees(elevation_deg), 1.0});
}

// Rings of equal elevation, as in laboratory measurements: four neighbours are on one circle.
std::vector<Vector3> rings() {
  std::vector<Vector3> directions = {direction(0, 90), direction(0, -90)};
  for (int elevation = -80; elevation <= 80; elevation += 10) {
    for (int azimuth = 0; azimuth < 360; azimuth += 10) {
      directions.push_back(direction(azimuth, elevation));
    }
  }
  return directions;
}

Vector3 random_direction(RandomStream& random) {
  for (;;) {
    const Vector3 v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (norm(v) > 0.1 && norm(v) < 1.0) return normalized(v);
  }
}

TEST(DirectionMesh, ClosedHullHasTwoTrianglesPerDirectionLessFour) {
  const std::vector<Vector3> directions = rings();
  // Euler's formula for a triangulated sphere.
  EXPECT_EQ(DirectionMesh(directions).triangles(), 2 * directions.size() - 4);
}

TEST(DirectionMesh, WeightsRebuildTheDirection) {
  const std::vector<Vector3> directions = rings();
  const DirectionMesh mesh(directions);
  RandomStream random(1);
  for (int i = 0; i < 2000; ++i) {
    const Vector3 wanted = random_direction(random);
    const DirectionMesh::Place place = mesh.locate(wanted * 3.0);
    Vector3 sum;
    double total = 0.0;
    for (int corner = 0; corner < 3; ++corner) {
      EXPECT_GE(place.weights[corner], 0.0);
      total += place.weights[corner];
      sum = sum + place.weights[corner] * directions[place.corners[corner]];
      // The corners are those of the cell around it: a cell's diagonal is 14.2 degrees.
      EXPECT_GT(dot(directions[place.corners[corner]], wanted), std::cos(0.25));
    }
    EXPECT_NEAR(total, 1.0, 1e-12);
    EXPECT_NEAR(norm(normalized(sum) - wanted), 0.0, 1e-8);  // the edge tolerance
  }
}

TEST(DirectionMesh, AMeasuredDirectionIsItsOwnCorner) {
  const std::vector<Vector3> directions = rings();
  const DirectionMesh mesh(directions);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const DirectionMesh::Place place = mesh.locate(directions[i]);
    const auto largest = std::max_element(place.weights.begin(), place.weights.end());
    EXPECT_EQ(place.corners[largest - place.weights.begin()], static_cast<int>(i));
    EXPECT_NEAR(*largest, 1.0, 1e-8);
    EXPECT_EQ(mesh.nearest(directions[i] * 0.1), static_cast<int>(i));
  }
}

TEST(DirectionMesh, LeftAndRightAreAlike) {
  const std::vector<Vector3> directions = rings();
  const DirectionMesh mesh(directions);
  RandomStream random(2);
  for (int i = 0; i < 500; ++i) {
    const Vector3 left = random_direction(random);
    const Vector3 right{left.x, -left.y, left.z};
    std::array<double, 3> left_weights = mesh.locate(left).weights;
    std::array<double, 3> right_weights = mesh.locate(right).weights;
    std::sort(left_weights.begin(), left_weights.end());
    std::sort(right_weights.begin(), right_weights.end());
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(left_weights[k], right_weights[k], 1e-9);
  }
}

TEST(DirectionMesh, NearestGoesRoundTheBack) {
  std::vector<Vector3> directions = {direction(0, 90), direction(0, -90)};
  for (int azimuth = 0; azimuth < 360; azimuth += 5) directions.push_back(direction(azimuth, 0));
  const DirectionMesh mesh(directions);
  EXPECT_EQ(mesh.nearest(direction(358.0, 3.0)), 2);    // azimuth 0
  EXPECT_EQ(mesh.nearest(direction(-176.0, 0.0)), 39);  // azimuth 185
}

TEST(DirectionMesh, NearestIsTheNearestOfAll) {
  RandomStream random(4);
  std::vector<Vector3> directions;
  for (int i = 0; i < 300; ++i) directions.push_back(random_direction(random));
  const DirectionMesh mesh(directions);
  for (int i = 0; i < 5000; ++i) {
    const Vector3 wanted = random_direction(random);
    const auto best = std::ranges::max_element(
        directions, {}, [&](const Vector3& other) { return dot(other, wanted); });
    EXPECT_EQ(mesh.nearest(wanted), static_cast<int>(best - directions.begin()));
  }
}

TEST(DirectionMesh, AnEmptyHemisphereFallsBackToTheNearest) {
  std::vector<Vector3> directions;
  for (int elevation = 30; elevation <= 90; elevation += 20) {
    for (int azimuth = 0; azimuth < 360; azimuth += 45) {
      directions.push_back(direction(azimuth, elevation - 0.01));
    }
  }
  const DirectionMesh mesh(directions);
  const DirectionMesh::Place place = mesh.locate(direction(46.0, -60.0));
  EXPECT_EQ(place.corners[0], 1);
  EXPECT_EQ(place.weights[0], 1.0);
}

TEST(DirectionMesh, RefusesDirectionsInOnePlane) {
  std::vector<Vector3> directions;
  for (int azimuth = 0; azimuth < 360; azimuth += 30) directions.push_back(direction(azimuth, 0));
  EXPECT_THROW(DirectionMesh{directions}, std::logic_error);
}

}  // namespace
}  // namespace earpoint

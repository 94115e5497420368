#include "triangle_tree.h"

#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/scene/scene.h>

namespace earpoint {
namespace {

// Length of a ray inside a box up to the wall.
double to_wall_m(const Vector3& lengths, const Vector3& origin, const Vector3& direction) {
  const auto along = [](double length, double o, double d) {
    return d == 0.0 ? 1e30 : ((d > 0.0 ? length : 0.0) - o) / d;
  };
  return std::min({along(lengths.x, origin.x, direction.x), along(lengths.y, origin.y, direction.y),
                   along(lengths.z, origin.z, direction.z)});
}

class TriangleTreeTest : public ::testing::Test {
 protected:
  const Vector3 lengths_{6, 5, 3};
  Scene scene_ = make_shoebox(lengths_, all_bands(0.0F), all_bands(0.0F));
  // The two triangles of the ceiling are in a layer of their own.
  std::vector<LayerMask> layers_ = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2};
  TriangleTree tree_{scene_.mesh, layers_};
  RandomStream random_{3};

  Vector3 random_point() {
    return {random_.uniform(0.1, 5.9), random_.uniform(0.1, 4.9), random_.uniform(0.1, 2.9)};
  }
  Vector3 random_direction() {
    return normalized(Vector3{random_.normal(), random_.normal(), random_.normal()});
  }
};

TEST_F(TriangleTreeTest, FindsTheWallThatARayMeets) {
  for (int i = 0; i < 1000; ++i) {
    const Vector3 origin = random_point();
    const Vector3 direction = random_direction();
    const std::optional<TriangleHit> hit = tree_.closest(origin, direction, 100.0, kAllLayers);
    ASSERT_TRUE(hit.has_value());
    const double expected = to_wall_m(lengths_, origin, direction);
    EXPECT_NEAR(hit->distance_m, expected, 1e-5 * expected + 1e-5);  // single precision
    const Vector3 point = origin + direction * expected;
    const Vector3 normal = normalized(scaled_normal(scene_.mesh, hit->triangle));
    const Vector3 corner = vertex(scene_.mesh, scene_.mesh.triangles[hit->triangle][0]);
    EXPECT_NEAR(dot(normal, point - corner), 0.0, 1e-5);
  }
}

TEST_F(TriangleTreeTest, PacketsFindWhatSingleRaysFind) {
  SoundRayPacket packet;
  std::vector<Vector3> origins;
  std::vector<Vector3> directions;
  for (int lane = 0; lane < kPacketSize; ++lane) {
    origins.push_back(random_point());
    directions.push_back(random_direction());
    if (lane == 5) continue;  // not valid
    packet.set(lane,
               {static_cast<float>(origins[lane].x), static_cast<float>(origins[lane].y),
                static_cast<float>(origins[lane].z)},
               {static_cast<float>(directions[lane].x), static_cast<float>(directions[lane].y),
                static_cast<float>(directions[lane].z)},
               100.0F, kAllLayers);
  }
  tree_.closest(packet);
  for (int lane = 0; lane < kPacketSize; ++lane) {
    if (lane == 5) continue;
    const auto single = tree_.closest(origins[lane], directions[lane], 100.0, kAllLayers);
    ASSERT_TRUE(packet.hit(lane) && single.has_value());
    EXPECT_EQ(packet.triangles[lane], single->triangle);
    // Packets compute in float, of distances of up to 10 m.
    EXPECT_NEAR(packet.rays.ray.tfar[lane], single->distance_m, 1e-5F);
  }
}

TEST_F(TriangleTreeTest, OfWallsThatLieOnEachOtherTheLastOneIsMet) {
  // The box twice: the copies' triangles come after the originals and coincide with them.
  Mesh doubled = scene_.mesh;
  const std::size_t triangles = doubled.triangles.size();
  for (std::size_t i = 0; i < triangles; ++i) doubled.triangles.push_back(doubled.triangles[i]);
  std::vector<LayerMask> layers(triangles, 1);
  layers.resize(2 * triangles, 2);
  const TriangleTree tree(doubled, layers);
  for (int i = 0; i < 100; ++i) {
    const Vector3 origin = random_point();
    const Vector3 direction = random_direction();
    const auto of_both = tree.closest(origin, direction, 100.0, 3);
    const auto of_originals = tree.closest(origin, direction, 100.0, 1);
    ASSERT_TRUE(of_both && of_originals);
    EXPECT_GE(of_both->triangle, triangles);
    EXPECT_EQ(of_originals->triangle, of_both->triangle - triangles);
  }
}

TEST_F(TriangleTreeTest, RaysSeeOnlyTheirLayers) {
  const Vector3 middle{3, 2.5, 1.5};
  EXPECT_TRUE(tree_.closest(middle, {0, 0, 1}, 10.0, 2U).has_value());
  EXPECT_FALSE(tree_.closest(middle, {0, 0, 1}, 10.0, 1U).has_value());
  EXPECT_TRUE(tree_.occluded(middle, {3, 2.5, 5}, 2U));
  EXPECT_FALSE(tree_.occluded(middle, {3, 2.5, 5}, 1U));
  EXPECT_FALSE(tree_.occluded(middle, {3, 2.5, 2.9}, kAllLayers));
}

TEST_F(TriangleTreeTest, NoRaySlipsThroughAnEdge) {
  // At the edges and corners of the box, where triangles meet.
  for (int i = 0; i < 10'000; ++i) {
    Vector3 target{random_.uniform() < 0.5 ? 0.0 : 6.0, random_.uniform() < 0.5 ? 0.0 : 5.0,
                   random_.uniform(0.0, 3.0)};
    if (i % 3 == 0) target.z = 3.0;
    const Vector3 origin = random_point();
    EXPECT_TRUE(tree_.closest(origin, normalized(target - origin), 100.0, kAllLayers));
  }
}

}  // namespace
}  // namespace earpoint

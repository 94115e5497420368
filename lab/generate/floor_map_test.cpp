#include <gtest/gtest.h>

#include <earpoint/generate/floor_map.h>
#include <earpoint/generate_testing/quick_generation.h>
#include <earpoint/scene/homes.h>

namespace earpoint {
namespace {

FloorMap map_of(const Scene& scene) { return {scene, RayCaster(scene.mesh)}; }

TEST(FloorMap, AnEmptyRoomIsFreeFromWallToWall) {
  const FloorMap map = map_of(make_shoebox({4, 3, 2.5}, all_bands(0.2F), all_bands(0.2F)));
  EXPECT_NEAR(map.floor_m(), 0.0, 1e-6);
  // Off by at most one cell of 5 cm along each wall.
  EXPECT_NEAR(map.area_m2(), 12.0, 0.05 * 14);
  // The clearance is never more than the truth, and short of it by at most two and a half cells.
  for (const FloorPoint point : {FloorPoint{2, 1.5}, {0.5, 1.0}, {3.9, 1.5}}) {
    const double truth_m = std::min({point.x, 4 - point.x, point.y, 3 - point.y});
    EXPECT_LE(map.clearance_m(point), truth_m + 1e-9);
    EXPECT_GE(map.clearance_m(point), truth_m - 0.125);
  }
  EXPECT_EQ(map.clearance_m({5, 1}), 0.0);
}

TEST(FloorMap, TablesAndWallsAreNoPlaceToStand) {
  const FloorMap map = map_of(two_rooms());
  EXPECT_EQ(map.clearance_m({1.6, 0.6}), 0.0);   // under the table
  EXPECT_EQ(map.clearance_m({6.06, 1.0}), 0.0);  // in the wall
  EXPECT_GT(map.clearance_m({6.06, 3.5}), 0.3);  // in the doorway
  EXPECT_GT(map.clearance_m({3.0, 2.5}), 0.5);
}

TEST(FloorMap, AWalkGoesThroughTheDoorway) {
  const FloorMap map = map_of(two_rooms());
  // The two sides are 0.5 m apart through the wall, and over 5 m by the door.
  const FloorPoint from{5.8, 0.5};
  const auto reaches = [&](double longest_m) {
    const auto places = map.within_walk(from, longest_m);
    return std::any_of(places.begin(), places.end(), [](const FloorPoint& place) {
      return distance_m(place, {6.4, 0.5}) < 0.1;
    });
  };
  EXPECT_FALSE(reaches(5.0));
  EXPECT_TRUE(reaches(6.5));
}

TEST(FloorMap, AFloorAtAnyHeightIsFound) {
  Scene scene = two_rooms();
  for (auto& position : scene.mesh.positions) position[2] += 3.4F;
  const FloorMap map = map_of(scene);
  // Floats of 6 m are precise to 5e-7 m; rays go on 1 mm behind a face.
  EXPECT_NEAR(map.floor_m(), 3.4, 1e-3);
  EXPECT_GT(map.clearance_m({3.0, 2.5}), 0.5);
}

TEST(FloorMap, DrawnPlacesInHomesAreFree) {
  const FurnitureLibrary stand_ins;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Home home = make_home(seed, {}, stand_ins);
    const FloorMap map = map_of(home.scene);
    RandomStream random(seed);
    int too_near = 0;
    for (int i = 0; i < 200; ++i) {
      const auto place = map.draw(0.3, random);
      ASSERT_TRUE(place);
      // The home's own list has only bounding rectangles of furniture, and no free space in
      // doorways.
      too_near += is_free(home, place->x, place->y, 0.2) ? 0 : 1;
    }
    EXPECT_LE(too_near, 10) << "home " << seed;
  }
}

}  // namespace
}  // namespace earpoint

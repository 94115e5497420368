#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/scene/homes.h>
#include <earpoint/scene/material_table.h>
#include <earpoint/scene/reverberation_estimate.h>

namespace earpoint {
namespace {

constexpr std::uint64_t kHomes = 24;

const std::vector<Home>& many_homes() {
  static const std::vector<Home> homes = [] {
    std::vector<Home> made;
    for (std::uint64_t seed = 0; seed < kHomes; ++seed) {
      made.push_back(make_home(seed, {}, FurnitureLibrary()));
    }
    return made;
  }();
  return homes;
}

/// The faces of walls, floors and ceilings, without the leaves of closed doors.
std::vector<std::size_t> shell_faces(const Home& home) {
  std::vector<std::size_t> faces;
  const Mesh& mesh = home.scene.mesh;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (home.scene.instances[mesh.triangle_instance[i]].name != "shell") continue;
    if (home.scene.materials[mesh.triangle_material[i]].acoustic.name == "door_wood") continue;
    faces.push_back(i);
  }
  return faces;
}

TEST(Homes, EveryEdgeOfTheShellBelongsToTwoFacesThatTurnAlike) {
  using Point = std::array<float, 3>;
  for (const Home& home : many_homes()) {
    const Mesh& mesh = home.scene.mesh;
    std::map<std::pair<Point, Point>, int> edges;
    for (const std::size_t face : shell_faces(home)) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const Point& from = mesh.positions[mesh.triangles[face][corner]];
        const Point& to = mesh.positions[mesh.triangles[face][(corner + 1) % 3]];
        ++edges[{from, to}];
      }
    }
    for (const auto& [edge, count] : edges) {
      const auto back = edges.find({edge.second, edge.first});
      ASSERT_EQ(count, 1);
      ASSERT_NE(back, edges.end());
      ASSERT_EQ(back->second, 1);
    }
  }
}

TEST(Homes, TheShellEnclosesExactlyTheAirOfThePlan) {
  for (const Home& home : many_homes()) {
    double air_m3 = 0.0;
    for (const Room& room : home.plan.rooms) air_m3 += room.floor.area_m2() * room.ceiling_m;
    for (const Door& door : home.plan.doors) air_m3 += door.opening.area_m2() * door.height_m;
    for (const HomeWindow& window : home.plan.windows) {
      air_m3 += window.recess.area_m2() * (window.head_m - window.sill_m);
    }
    double enclosed_m3 = 0.0;
    const Mesh& mesh = home.scene.mesh;
    for (const std::size_t face : shell_faces(home)) {
      const auto& [a, b, c] = mesh.triangles[face];
      enclosed_m3 -= dot(vertex(mesh, a), cross(vertex(mesh, b), vertex(mesh, c))) / 6.0;
    }
    // Coordinates are floats: some 1e-7 of 15 m, on up to 700 m2 of surface.
    EXPECT_NEAR(enclosed_m3, air_m3, 1e-3);
  }
}

TEST(Homes, AClosedDoorIsOneSheetThatFillsItsOpening) {
  for (const Home& home : many_homes()) {
    double expected_m2 = 0.0;
    for (const Door& door : home.plan.doors) {
      if (door.state != DoorState::closed || door.room_b == Door::kOutside) continue;
      expected_m2 += std::max(door.opening.width_m(), door.opening.depth_m()) * door.height_m;
    }
    double found_m2 = 0.0;
    const Mesh& mesh = home.scene.mesh;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      if (home.scene.instances[mesh.triangle_instance[i]].name == "shell" &&
          home.scene.materials[mesh.triangle_material[i]].acoustic.name == "door_wood") {
        found_m2 += norm(scaled_normal(mesh, i)) / 2.0;
      }
    }
    EXPECT_NEAR(found_m2, expected_m2, 1e-4);  // floats
  }
}

TEST(Homes, FurnitureStandsInItsRoomAndInNothingElse) {
  for (const Home& home : many_homes()) {
    for (std::size_t i = 0; i < home.furniture.size(); ++i) {
      const PlacedFurniture& a = home.furniture[i];
      const Room& room = home.plan.rooms[static_cast<std::size_t>(a.room)];
      EXPECT_GE(a.footprint.x_min, room.floor.x_min) << a.name;
      EXPECT_GE(a.footprint.y_min, room.floor.y_min) << a.name;
      EXPECT_LE(a.footprint.x_max, room.floor.x_max) << a.name;
      EXPECT_LE(a.footprint.y_max, room.floor.y_max) << a.name;
      EXPECT_LE(a.z_high_m, room.ceiling_m) << a.name;
      for (std::size_t j = i + 1; j < home.furniture.size(); ++j) {
        const PlacedFurniture& b = home.furniture[j];
        // Furniture may stand on a rug and sink into its pile.
        const bool rugs = (a.kind == FurnitureKind::rug) != (b.kind == FurnitureKind::rug);
        const bool apart = rugs || !overlap(a.footprint, b.footprint) || a.z_low_m >= b.z_high_m ||
                           b.z_low_m >= a.z_high_m;
        EXPECT_TRUE(apart) << a.name << " and " << b.name;
      }
    }
  }
}

TEST(Homes, FurnitureFillsTheBoxThatIsSaidOfIt) {
  for (const Home& home : many_homes()) {
    const Mesh& mesh = home.scene.mesh;
    std::map<std::uint32_t, Bounds> boxes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (const std::uint32_t v : mesh.triangles[i]) {
        const Vector3 p = vertex(mesh, v);
        auto [box, is_new] = boxes.try_emplace(mesh.triangle_instance[i], Bounds{p, p});
        Bounds& b = box->second;
        b.low = {std::min(b.low.x, p.x), std::min(b.low.y, p.y), std::min(b.low.z, p.z)};
        b.high = {std::max(b.high.x, p.x), std::max(b.high.y, p.y), std::max(b.high.z, p.z)};
      }
    }
    for (const PlacedFurniture& piece : home.furniture) {
      const Bounds& box = boxes.at(piece.instance);
      constexpr double kSlack_m = 1e-5;  // floats at some 15 m
      EXPECT_GE(box.low.x, piece.footprint.x_min - kSlack_m) << piece.name;
      EXPECT_GE(box.low.y, piece.footprint.y_min - kSlack_m) << piece.name;
      EXPECT_GE(box.low.z, piece.z_low_m - kSlack_m) << piece.name;
      EXPECT_LE(box.high.x, piece.footprint.x_max + kSlack_m) << piece.name;
      EXPECT_LE(box.high.y, piece.footprint.y_max + kSlack_m) << piece.name;
      EXPECT_LE(box.high.z, piece.z_high_m + kSlack_m) << piece.name;
    }
  }
}

TEST(Homes, SkirtingLiesAtWallsAndEndsBeforeDoorways) {
  for (const Home& home : many_homes()) {
    const Mesh& mesh = home.scene.mesh;
    double area_m2 = 0.0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      if (home.scene.instances[mesh.triangle_instance[i]].name != "skirting") continue;
      area_m2 += norm(scaled_normal(mesh, i)) / 2.0;
      for (const std::uint32_t v : mesh.triangles[i]) {
        const Vector3 p = vertex(mesh, v);
        const int room = room_at(home.plan, p.x, p.y);
        ASSERT_GE(room, 0);
        const FloorRectangle& floor = home.plan.rooms[static_cast<std::size_t>(room)].floor;
        EXPECT_FALSE(grown(floor, -0.02).contains(p.x, p.y));
        for (const Door& door : home.plan.doors) {
          EXPECT_FALSE(grown(door.opening, 0.049).contains(p.x, p.y));
        }
      }
    }
    EXPECT_GT(area_m2, 0.5);
  }
}

TEST(Homes, DoorsStayFreeOfFurniture) {
  for (const Home& home : many_homes()) {
    for (const Door& door : home.plan.doors) {
      const FloorRectangle before = grown(door.opening, 0.5);
      const bool along_y = door.side_of_a == Side::x_low || door.side_of_a == Side::x_high;
      const FloorRectangle way =
          along_y
              ? FloorRectangle{before.x_min, door.opening.y_min, before.x_max, door.opening.y_max}
              : FloorRectangle{door.opening.x_min, before.y_min, door.opening.x_max, before.y_max};
      for (const PlacedFurniture& piece : home.furniture) {
        if (piece.kind == FurnitureKind::rug || piece.z_low_m > 2.1) continue;
        EXPECT_FALSE(overlap(way, piece.footprint)) << piece.name;
      }
    }
  }
}

TEST(Homes, LeaveRoomForPeople) {
  for (const Home& home : many_homes()) {
    const FloorRectangle around = home.plan.footprint();
    RandomStream random(5);
    int free_spots = 0;
    for (int i = 0; i < 1000; ++i) {
      const double x = random.uniform(around.x_min, around.x_max);
      const double y = random.uniform(around.y_min, around.y_max);
      if (is_free(home, x, y, 0.3)) ++free_spots;
    }
    EXPECT_GT(free_spots, 100);
  }
}

TEST(Homes, IsFreeKnowsWallsFurnitureAndRugs) {
  const Home& home = many_homes()[1];
  const FloorRectangle around = home.plan.footprint();
  EXPECT_FALSE(is_free(home, around.x_min - 1.0, around.y_min, 0.2));
  EXPECT_EQ(room_at(home.plan, around.x_min - 1.0, around.y_min), -1);
  EXPECT_FALSE(is_free(home, around.x_min + 0.1, around.y_min + 0.1, 0.2));
  for (const PlacedFurniture& piece : home.furniture) {
    if (piece.z_high_m < 0.03 || piece.z_low_m > 2.0) continue;
    EXPECT_FALSE(is_free(home, piece.footprint.centre_x(), piece.footprint.centre_y(), 0.2))
        << piece.name;
  }
}

TEST(Homes, EverySurfaceHasAStandardSoundAndIsUsed) {
  for (const Home& home : many_homes()) {
    std::set<std::uint32_t> used(home.scene.mesh.triangle_material.begin(),
                                 home.scene.mesh.triangle_material.end());
    EXPECT_EQ(used.size(), home.scene.materials.size());
    for (const Material& material : home.scene.materials) {
      const AcousticMaterial* row = standard_materials().find(material.acoustic.name);
      ASSERT_NE(row, nullptr) << material.acoustic.name;
      EXPECT_EQ(row->absorption, material.acoustic.absorption);
    }
    EXPECT_EQ(home.scene.lamps.size(), home.plan.rooms.size());
    EXPECT_LE(home.scene.mesh.triangles.size(), HomeOptions{}.most_triangles);
  }
}

bool same_bytes(const Scene& a, const Scene& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
  };
  if (a.textures.size() != b.textures.size()) return false;
  for (std::size_t i = 0; i < a.textures.size(); ++i) {
    if (!same(a.textures[i].pixels(), b.textures[i].pixels())) return false;
  }
  return same(a.mesh.positions, b.mesh.positions) && same(a.mesh.triangles, b.mesh.triangles) &&
         same(a.mesh.triangle_material, b.mesh.triangle_material) && same(a.mesh.uvs, b.mesh.uvs);
}

TEST(Homes, TheSameSeedGivesTheSameBytes) {
  const Home again = make_home(3, {}, FurnitureLibrary());
  EXPECT_TRUE(same_bytes(again.scene, many_homes()[3].scene));
  EXPECT_FALSE(same_bytes(again.scene, many_homes()[4].scene));
}

double middle_band_reverberation_s(const Home& home) {
  double weighted = 0.0;
  double volume_m3 = 0.0;
  for (const ReverberationEstimate& room : estimate_reverberation(home)) {
    weighted += room.volume_m3 * (room.eyring_s[3] + room.eyring_s[4]) / 2.0;
    volume_m3 += room.volume_m3;
  }
  return weighted / volume_m3;
}

TEST(Homes, ReverberateFromDryToLivelyButNotLikeStudiosOrChurches) {
  std::vector<double> times_s;
  for (const Home& home : many_homes()) times_s.push_back(middle_band_reverberation_s(home));
  const auto [shortest, longest] = std::minmax_element(times_s.begin(), times_s.end());
  // By Eyring's formula. The median of traced responses is 1.6 times as long (docs/results.md):
  // 0.31 to 1.28 s there.
  EXPECT_GT(*shortest, 0.11);
  EXPECT_LT(*shortest, 0.25);
  EXPECT_GT(*longest, 0.6);
  EXPECT_LT(*longest, 1.0);
}

TEST(Homes, SoftnessAndFurnitureShortenReverberation) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto reverberation_s = [&](double softness, double furnishing) {
      return middle_band_reverberation_s(
          make_home(seed, {.softness = softness, .furnishing = furnishing}, FurnitureLibrary()));
    };
    EXPECT_LT(reverberation_s(0.8, 0.6), 0.7 * reverberation_s(0.1, 0.6));
    EXPECT_LT(reverberation_s(0.1, 1.0), reverberation_s(0.1, 0.0));
  }
}

TEST(Homes, RefusesSharesOutsideZeroToOne) {
  try {
    make_home(1, {.softness = 1.5}, FurnitureLibrary());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "home: softness: expected 0 to 1, found 1.5");
  }
}

TEST(ReverberationEstimate, OfABareRoomIsEyringsFormula) {
  Home home;
  home.plan.rooms.push_back({.kind = RoomKind::living_room, .floor = {0, 0, 6, 5}, .ceiling_m = 3});
  home.scene = make_shoebox({6, 5, 3}, all_bands(0.2F), all_bands(0.5F));
  const ReverberationEstimate room = estimate_reverberation(home).at(0);
  // 90 m3, 126 m2: the closed forms, to the rounding of 0.2 as a float.
  EXPECT_NEAR(room.sabine_s[3], 0.161 * 90.0 / (126.0 * 0.2), 1e-6);
  EXPECT_NEAR(room.eyring_s[3], 0.161 * 90.0 / (-126.0 * std::log(0.8)), 1e-6);
}

}  // namespace
}  // namespace earpoint

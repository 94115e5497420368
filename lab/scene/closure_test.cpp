#include <gtest/gtest.h>

#include <earpoint/scene/closure.h>
#include <earpoint/scene/homes.h>
#include <earpoint/scene/scene_builder.h>

namespace earpoint {
namespace {

Scene room() { return make_shoebox({5, 4, 2.6}, all_bands(0.1F), all_bands(0.1F)); }

/// Removes the faces of one material: in a shoebox, one of its sides.
Scene without(Scene scene, std::uint32_t material) {
  Mesh& mesh = scene.mesh;
  for (std::size_t i = mesh.triangles.size(); i-- > 0;) {
    if (mesh.triangle_material[i] != material) continue;
    const auto at = static_cast<std::ptrdiff_t>(i);
    mesh.triangles.erase(mesh.triangles.begin() + at);
    mesh.triangle_material.erase(mesh.triangle_material.begin() + at);
    mesh.triangle_instance.erase(mesh.triangle_instance.begin() + at);
  }
  return scene;
}

TEST(Closure, AShoeboxIsTight) {
  const Closure closure = check_closure(room());
  EXPECT_GE(closure.rays, 5000U);
  EXPECT_EQ(closure.escaping_share, 0.0);
  EXPECT_EQ(closure.open_edges, 0U);
}

TEST(Closure, AMissingCeilingLetsRaysUpAndLeavesItsRimOpen) {
  const Closure closure = check_closure(without(room(), 5));
  EXPECT_GT(closure.escaping_share, 0.1);
  EXPECT_GT(closure.escaping_up_share, 0.5 * closure.escaping_share);
  EXPECT_EQ(closure.open_edges, 4U);
  EXPECT_NEAR(closure.open_edges_m, 18.0, 1e-4);  // floats of some metres
}

TEST(Closure, AMissingWallIsNoMissingCeiling) {
  const Closure closure = check_closure(without(room(), 1));
  EXPECT_GT(closure.escaping_share, 0.05);
  EXPECT_LT(closure.escaping_up_share, 0.5 * closure.escaping_share);
}

TEST(Closure, HomesAreTight) {
  for (const std::uint64_t seed : {11, 12, 13}) {
    const Closure closure = check_closure(make_home(seed, {}, FurnitureLibrary()).scene);
    EXPECT_GE(closure.rays, 5000U);
    EXPECT_EQ(closure.escaping_share, 0.0) << seed;
  }
}

TEST(CloseCeiling, PutsALidOnAnOpenRoom) {
  Scene scene = without(room(), 5);
  Material lid;
  lid.acoustic.name = "lid";
  EXPECT_NEAR(close_ceiling(scene, lid), 20.0, 2.0);  // a grid of 0.1 m along 18 m of walls
  EXPECT_EQ(check_closure(scene).escaping_share, 0.0);
  EXPECT_EQ(scene.materials.back().acoustic.name, "lid");
  check_scene(scene, "closed room");
  // The lid lies on the walls, 1 mm above them.
  EXPECT_NEAR(bounds(scene.mesh).high.z, 2.6, 0.002);
}

TEST(CloseCeiling, LeavesAClosedSceneAsItIs) {
  Scene scene = room();
  const std::size_t before = scene.mesh.triangles.size();
  EXPECT_EQ(close_ceiling(scene, {}), 0.0);
  EXPECT_EQ(scene.mesh.triangles.size(), before);
}

TEST(CloseCeiling, ClosesARoomOfThickWallsAroundTallFurniture) {
  SceneBuilder builder;
  const Surface stone = builder.add_surface("stone", {});
  builder.begin_instance("walls", InstanceKind::structure);
  builder.add_box({-0.3, -0.3, -0.2}, {6.3, 5.3, 0.0}, stone);
  builder.add_box({-0.3, -0.3, 0.0}, {6.3, 0.0, 2.5}, stone);
  builder.add_box({-0.3, 5.0, 0.0}, {6.3, 5.3, 2.5}, stone);
  builder.add_box({-0.3, 0.0, 0.0}, {0.0, 5.0, 2.5}, stone);
  builder.add_box({6.0, 0.0, 0.0}, {6.3, 5.0, 2.5}, stone);
  builder.begin_instance("wardrobe", InstanceKind::furniture);
  builder.add_box({2.0, 2.0, 0.0}, {4.0, 2.6, 2.3}, stone);
  Scene scene = builder.take();
  EXPECT_GT(check_closure(scene).escaping_share, 0.1);
  EXPECT_NEAR(close_ceiling(scene, {}), 30.0, 2.5);  // a grid of 0.1 m along 22 m of walls
  EXPECT_EQ(check_closure(scene).escaping_share, 0.0);
}

TEST(CloseCeiling, KeepsTheCeilingThatIsThere) {
  // Two rooms under one roof, of which the second has no ceiling.
  SceneBuilder builder;
  const Surface stone = builder.add_surface("stone", {});
  builder.begin_instance("walls", InstanceKind::structure);
  for (const double x : {0.0, 4.0, 8.0}) builder.add_box({x, 0, 0}, {x + 0.1, 3.1, 2.5}, stone);
  for (const double y : {0.0, 3.0}) builder.add_box({0, y, 0}, {8.1, y + 0.1, 2.5}, stone);
  builder.add_box({0, 0, -0.1}, {8.1, 3.1, 0.0}, stone);
  builder.add_box({0, 0, 2.5}, {4.1, 3.1, 2.6}, stone);
  Scene scene = builder.take();
  EXPECT_NEAR(close_ceiling(scene, {}), 3.9 * 2.9, 1.5);  // a grid of 0.1 m along 14 m of walls
  EXPECT_EQ(check_closure(scene).escaping_share, 0.0);
}

}  // namespace
}  // namespace earpoint

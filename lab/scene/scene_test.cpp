#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/scene/scene.h>

namespace earpoint {
namespace {

Scene small_room() { return make_shoebox({4, 3, 2.5}, all_bands(0.2F), all_bands(0.5F)); }

std::string refusal(Scene scene) {
  try {
    check_scene(scene, "room.glb");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Scene, ShoeboxIsClosedAndFacesInward) {
  const Scene room = small_room();
  Vector3 sum;
  double area_m2 = 0.0;
  for (std::size_t i = 0; i < room.mesh.triangles.size(); ++i) {
    const Vector3 normal = scaled_normal(room.mesh, i);
    const Vector3 to_centre = Vector3{2, 1.5, 1.25} - vertex(room.mesh, room.mesh.triangles[i][0]);
    EXPECT_GT(dot(normal, to_centre), 0.0) << "triangle " << i;
    sum = sum + normal;
    area_m2 += norm(normal) / 2.0;
  }
  // Small whole numbers and halves: exact in float and double.
  EXPECT_EQ(sum, Vector3{});
  EXPECT_EQ(area_m2, 2.0 * (4 * 3 + 4 * 2.5 + 3 * 2.5));
}

TEST(Scene, ShoeboxKeepsTheOrderOfItsFaces) {
  std::array<AcousticMaterial, 6> faces;
  for (int i = 0; i < 6; ++i) faces[i].name = std::to_string(i);
  const Scene room = make_shoebox({4, 3, 2.5}, faces);
  const std::array<Vector3, 6> inward = {
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  for (std::size_t i = 0; i < 12; ++i) {
    const std::uint32_t face = room.mesh.triangle_material[i];
    EXPECT_EQ(room.materials[face].acoustic.name, std::to_string(i / 2));
    EXPECT_EQ(normalized(scaled_normal(room.mesh, i)), inward[i / 2]);
  }
}

TEST(Scene, CheckAcceptsAShoeboxAsItIs) {
  Scene room = small_room();
  EXPECT_EQ(check_scene(room, "room.glb").zero_area_triangles, 0U);
  EXPECT_EQ(room.mesh.triangles.size(), 12U);
}

TEST(Scene, CheckDropsAndCountsFacesWithoutArea) {
  Scene room = small_room();
  room.mesh.triangles.insert(room.mesh.triangles.begin() + 3, {1, 1, 2});
  room.mesh.triangle_material.insert(room.mesh.triangle_material.begin() + 3, 5);
  room.mesh.triangle_instance.insert(room.mesh.triangle_instance.begin() + 3, 0);
  EXPECT_EQ(check_scene(room, "room.glb").zero_area_triangles, 1U);
  EXPECT_EQ(room.mesh.triangles, small_room().mesh.triangles);
  EXPECT_EQ(room.mesh.triangle_material, small_room().mesh.triangle_material);
}

TEST(Scene, CheckNamesWhatIsWrongInOneLine) {
  Scene room = small_room();
  room.mesh.positions[3][1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(refusal(room), "room.glb: vertex 3 is not a finite number; repair the mesh");

  room = small_room();
  room.mesh.triangles.clear();
  EXPECT_EQ(refusal(room), "room.glb: has no faces; export it with its triangles");

  room = make_shoebox({10'500, 3, 2.5}, all_bands(0.2F), all_bands(0.5F));
  EXPECT_EQ(refusal(room),
            "room.glb: is 10500 m long, expected at most 10000 m; check the unit of length");

  room = small_room();
  room.mesh.triangle_material[7] = 6;
  EXPECT_EQ(refusal(room), "room.glb: face 7 has material 6, but there are 6");

  room = small_room();
  room.mesh.triangles[2][0] = 8;
  EXPECT_EQ(refusal(room), "room.glb: face 2 has vertex 8, but there are 8");

  room = small_room();
  room.mesh.triangle_instance.pop_back();
  EXPECT_EQ(refusal(room), "room.glb: triangle_instance has 11 entries, expected 12");

  room = small_room();
  for (auto& triangle : room.mesh.triangles) triangle = {0, 0, 1};
  EXPECT_EQ(refusal(room), "room.glb: has no face with an area; repair the mesh");

  room = small_room();
  room.materials[0].acoustic.absorption[2] = 1.5F;
  EXPECT_EQ(refusal(room), "room.glb: material 'wall': absorption 1.5 is outside [0, 1]");

  room = small_room();
  room.materials[0].acoustic.transmission[2] = 0.5F;
  EXPECT_EQ(refusal(room),
            "room.glb: material 'wall': transmission 0.5 is above absorption 0.2; absorption "
            "includes transmission");

  room = small_room();
  room.materials[0].look.texture = 0;
  EXPECT_EQ(refusal(room), "room.glb: material 'wall': texture 0 of 0");
}

}  // namespace
}  // namespace earpoint

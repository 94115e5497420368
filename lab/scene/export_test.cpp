#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/scene/export.h>
#include <earpoint/scene/homes.h>
#include <earpoint/scene/import.h>

namespace earpoint {
namespace {

std::map<std::string, double> area_by_sound_m2(const Scene& scene) {
  std::map<std::string, double> areas;
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
    areas[scene.materials[scene.mesh.triangle_material[i]].acoustic.name] +=
        norm(scaled_normal(scene.mesh, i)) / 2.0;
  }
  return areas;
}

TEST(Export, AHomeComesBackFromGlbWithItsShapeAndPictures) {
  const Home home = make_home(2, {}, FurnitureLibrary());
  const auto path = std::filesystem::path(EARPOINT_BINARY_DIR) / "export_test.glb";
  write_glb(home.scene, path);
  // A table that maps the names of the materials to themselves.
  std::string patterns;
  for (const AcousticMaterial& material : standard_materials().materials()) {
    patterns += (patterns.empty() ? "" : ",") + std::string(R"({"material": ")") + material.name +
                R"(", "words": [")" + material.name + R"("]})";
  }
  const MaterialTable table = MaterialTable::parse(
      R"({"format": "earpoint-materials-1", "extends": "standard", "patterns": [)" + patterns +
          "]}",
      "names");
  const ImportedScene back = import_scene(path, {.materials = &table});
  std::filesystem::remove(path);

  EXPECT_EQ(back.scene.mesh.triangles.size(), home.scene.mesh.triangles.size());
  EXPECT_EQ(back.scene.textures.size(), home.scene.textures.size());
  EXPECT_TRUE(back.report.warnings().empty());
  EXPECT_EQ(back.report.closure.escaping_share, 0.0);
  const Bounds ours = bounds(home.scene.mesh);
  const Bounds theirs = bounds(back.scene.mesh);
  EXPECT_EQ(ours.low, theirs.low);
  EXPECT_EQ(ours.high, theirs.high);
  const auto before = area_by_sound_m2(home.scene);
  const auto after = area_by_sound_m2(back.scene);
  ASSERT_EQ(before.size(), after.size());
  for (const auto& [name, area_m2] : before) EXPECT_NEAR(after.at(name), area_m2, 1e-6) << name;
}

}  // namespace
}  // namespace earpoint

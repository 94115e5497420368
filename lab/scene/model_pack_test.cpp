#include "mannequin.h"
#include "simplify.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/scene/material_table.h>
#include <earpoint/scene/model_pack.h>
#include <earpoint/scene/sweet_home.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class ModelPackFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(EARPOINT_BINARY_DIR) / "model_pack_test" /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }

 private:
  fs::path folder_;
};

/// A chair that carries a picture.
ModelPack small_pack() {
  SceneBuilder builder;
  Material material;
  material.acoustic = standard_material("chair_wood");
  material.look.texture = builder.add_texture(Image(3, 2, 3, std::uint8_t{9}));
  const Surface surface = builder.add_surface("wood", material);
  builder.begin_instance("chair", InstanceKind::furniture);
  builder.add_box({-0.2, -0.2, 0}, {0.2, 0.2, 0.9}, surface);
  FurnitureModel chair;
  chair.name = "a chair";
  chair.kind = FurnitureKind::chair;
  chair.size_m = {0.4, 0.4, 0.9};
  chair.base_m = 0.25;
  chair.scene = builder.take();
  chair.credit = "A. Maker; CC0";
  ModelPack pack;
  pack.furniture.push_back(chair);
  pack.figures.push_back(make_mannequin(Gender::male, Posture::sitting));
  pack.figures[0].for_test = true;
  return pack;
}

TEST_F(ModelPackFile, GivesBackWhatWasWritten) {
  const ModelPack pack = small_pack();
  write_model_pack(pack, file("models.pack"));
  const ModelPack back = read_model_pack(file("models.pack"));
  ASSERT_EQ(back.furniture.size(), 1U);
  const FurnitureModel& chair = back.furniture[0];
  EXPECT_EQ(chair.name, "a chair");
  EXPECT_EQ(chair.kind, FurnitureKind::chair);
  EXPECT_EQ(chair.size_m, pack.furniture[0].size_m);
  EXPECT_EQ(chair.base_m, 0.25);
  EXPECT_EQ(chair.credit, "A. Maker; CC0");
  EXPECT_EQ(chair.scene.mesh.positions, pack.furniture[0].scene.mesh.positions);
  EXPECT_EQ(chair.scene.mesh.normals, pack.furniture[0].scene.mesh.normals);
  EXPECT_EQ(chair.scene.mesh.uvs, pack.furniture[0].scene.mesh.uvs);
  EXPECT_EQ(chair.scene.mesh.triangles, pack.furniture[0].scene.mesh.triangles);
  EXPECT_EQ(chair.scene.materials[0].acoustic.name, "chair_wood");
  ASSERT_EQ(chair.scene.textures.size(), 1U);
  EXPECT_EQ(chair.scene.textures[0].width(), 3);
  EXPECT_EQ(chair.scene.textures[0].at(2, 1, 2), 9);
  ASSERT_EQ(back.figures.size(), 1U);
  EXPECT_EQ(back.figures[0].posture, Posture::sitting);
  EXPECT_TRUE(back.figures[0].for_test);
  EXPECT_EQ(back.figures[0].mouth_m, pack.figures[0].mouth_m);
  EXPECT_EQ(back.figures[0].seat_m, pack.figures[0].seat_m);
}

std::string refusal(const fs::path& path) {
  try {
    read_model_pack(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST_F(ModelPackFile, RefusesDamage) {
  write_model_pack(small_pack(), file("models.pack"));
  const std::string whole = read_text_file(file("models.pack"));
  for (std::size_t length = 0; length < whole.size(); length += whole.size() / 37) {
    write_file(file("cut.pack"), std::string_view(whole).substr(0, length));
    const std::string message = refusal(file("cut.pack"));
    EXPECT_NE(message, "accepted") << length;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
  std::string other = whole;
  other.replace(other.find("models-1"), 8, "models-9");
  write_file(file("other.pack"), std::string_view(other));
  EXPECT_NE(refusal(file("other.pack")).find("it is of another version"), std::string::npos);
}

/// The pack has one valid chair and one valid figure, as its reader promises.
void expect_usable(const ModelPack& pack) {
  ASSERT_EQ(pack.furniture.size(), 1U);
  ASSERT_EQ(pack.figures.size(), 1U);
  for (const Scene* scene : {&pack.furniture[0].scene, &pack.figures[0].scene}) {
    const Mesh& mesh = scene->mesh;
    EXPECT_FALSE(mesh.triangles.empty());
    EXPECT_EQ(mesh.triangle_material.size(), mesh.triangles.size());
    EXPECT_EQ(mesh.triangle_instance.size(), mesh.triangles.size());
    for (const auto& position : mesh.positions) {
      for (const float value : position) EXPECT_TRUE(std::isfinite(value));
    }
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t index : triangle) EXPECT_LT(index, mesh.positions.size());
    }
    for (const std::uint32_t index : mesh.triangle_material)
      EXPECT_LT(index, scene->materials.size());
    for (const Material& material : scene->materials) {
      EXPECT_NE(standard_materials().find(material.acoustic.name), nullptr)
          << material.acoustic.name;
      EXPECT_LT(material.look.texture, static_cast<int>(scene->textures.size()));
    }
  }
  for (const Image& texture : pack.furniture[0].scene.textures) {
    EXPECT_EQ(texture.width() * texture.height(), 6) << "as many as pixels are stored";
  }
  EXPECT_GT(pack.furniture[0].size_m.z, 0.0);
  EXPECT_GT(pack.figures[0].size_m.z, 0.0);
}

TEST_F(ModelPackFile, AnotherByteInItsHeaderIsRefusedOrLeavesAUsablePack) {
  write_model_pack(small_pack(), file("models.pack"));
  const std::string whole = read_text_file(file("models.pack"));
  const std::size_t header = whole.find('\n');
  RandomStream random(5);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 500; ++i) {
    // Any byte, or a digit that is replaced by another digit.
    std::string changed = whole;
    std::size_t place = random.index(header);
    char byte = static_cast<char>(random.index(256));
    if (i % 2 == 1) {
      place = whole.find_first_of("123456789", place);
      if (place >= header) continue;
      byte = static_cast<char>('0' + random.index(10));
    }
    changed[place] = byte;
    write_file(file("changed.pack"), std::string_view(changed));
    SCOPED_TRACE(changed.substr(place < 40 ? 0 : place - 40, 80));
    if (refusal(file("changed.pack")) != "accepted") {
      ++refused;
      continue;
    }
    ++accepted;
    expect_usable(read_model_pack(file("changed.pack")));
  }
  // Most bytes are names of fields, punctuation, offsets and counts; the rest are sizes, colours
  // and names of things.
  EXPECT_GT(refused, 200);
  EXPECT_GT(accepted, 50);
}

/// An open book of n by n squares, 2 m wide, 1 m deep, 0.5 m high, in the file's axes and units.
void write_model(const fs::path& folder, const std::string& name, int n) {
  fs::create_directories(folder / "things" / name);
  std::string obj = "mtllib " + name + ".mtl\nusemtl cover_fabric\n";
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = 20.0 * i / n;
      obj += "v " + std::to_string(x) + " " + std::to_string(std::abs(x - 10.0)) + " " +
             std::to_string(7.0 * j / n) + "\n";
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i + 1;
      obj += "f " + std::to_string(a) + " " + std::to_string(a + n + 1) + " " +
             std::to_string(a + n + 2) + " " + std::to_string(a + 1) + "\n";
    }
  }
  write_file(folder / "things" / name / (name + ".obj"), std::string_view(obj));
  write_file(folder / "things" / name / (name + ".mtl"),
             std::string_view("newmtl cover_fabric\nKd 1 0 0\n"));
}

TEST_F(ModelPackFile, ConvertsModelsOfSweetHome) {
  const fs::path library = file("Mine");
  write_model(library, "book", 80);
  write_model(library, "turned", 2);
  fs::create_directories(library / "things/broken");
  write_file(library / "things/broken/broken.obj", std::string_view("nothing\n"));
  write_file(library / "PluginFurnitureCatalog.properties",
             std::string_view("# a catalogue\nlicense=CC0\n"
                              "id#1=a\nmodel#1=/things/book/book.obj\nwidth#1=200\ndepth#1=100\n"
                              "height#1=50\ncreator#1=Somebody\nelevation#1=30\n"
                              "model#2=/things/turned/turned.obj\nwidth#2=200\ndepth#2=50\n"
                              "height#2=100\nmodelRotation#2=1 0 0 0 0 1 0 -1 0\n"
                              "model#3=/things/broken/broken.obj\nwidth#3=1\ndepth#3=1\n"
                              "height#3=1\n"));
  const auto row = [](const char* name, const char* sound) {
    return std::string(R"({"library": "Mine", "kind": "chair", "model": ")") + name +
           R"(", "sound": ")" + sound + "\"}";
  };
  write_file(file("list.json"), std::string_view(R"({"furniture": [)" + row("book", "chair_wood") +
                                                 "," + row("turned", "glass") + "," +
                                                 row("broken", "glass") + R"(], "figures": []})"));
  const SweetHomeResult result = convert_sweet_home(file(""), file("list.json"));
  ASSERT_EQ(result.pack.furniture.size(), 2U);
  ASSERT_EQ(result.left_out.size(), 1U);
  EXPECT_TRUE(result.left_out[0].starts_with("Mine/broken: ")) << result.left_out[0];

  const FurnitureModel& book = result.pack.furniture[0];
  EXPECT_EQ(book.credit, "Somebody; CC0");
  EXPECT_EQ(book.base_m, 0.3);
  EXPECT_EQ(book.scene.materials[0].acoustic.name, "upholstery_fabric") << "by its name";
  const Bounds box = bounds(book.scene.mesh);
  EXPECT_NEAR(norm(box.low - Vector3{-0.5, -1.0, 0.0}), 0.0, 1e-6);  // floats
  EXPECT_NEAR(norm(box.high - Vector3{0.5, 1.0, 0.5}), 0.0, 1e-6);
  EXPECT_LE(book.scene.mesh.triangles.size(), 5000U) << "simplified from 12,800";
  double area_m2 = 0.0;
  for (std::size_t i = 0; i < book.scene.mesh.triangles.size(); ++i) {
    area_m2 += norm(scaled_normal(book.scene.mesh, i)) / 2.0;
  }
  // Two flat pages, each as long as the hypotenuse of 1 m and 0.5 m. Simplification may fold
  // slivers within a plane, which costs no error, but must not make holes.
  EXPECT_GE(area_m2, 2.0 * std::sqrt(1.25) - 1e-3);
  EXPECT_LE(area_m2, 2.0 * std::sqrt(1.25) + 0.1);

  // Turned about x: the file's z becomes y and its y becomes -z, so that depth becomes height.
  const Mesh& turned = result.pack.furniture[1].scene.mesh;
  const Bounds turned_box = bounds(turned);
  EXPECT_NEAR(norm(turned_box.high - Vector3{0.25, 1.0, 1.0}), 0.0, 1e-6);
  double spine_x = 1.0;
  for (const auto& p : turned.positions) {
    if (std::abs(p[1]) < 1e-6F) spine_x = p[0];
  }
  EXPECT_NEAR(spine_x, 0.25, 1e-6) << "the spine, low before, is in front now";
}

TEST_F(ModelPackFile, NamesAListThatDoesNotFit) {
  fs::create_directories(file("Mine"));
  write_file(file("Mine") / "PluginFurnitureCatalog.properties", std::string_view("license=CC0\n"));
  write_file(file("list.json"),
             std::string_view(R"({"furniture": [{"library": "Mine", "model": "x", "kind": "chair",
                                 "sound": "glass"}], "figures": []})"));
  try {
    convert_sweet_home(file(""), file("list.json"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "Mine: has no model 'x'; is sweethome3d-furniture of another version installed?");
  }
}

TEST(InstalledModels, AreSoughtWhereTheEnvironmentSays) {
  const fs::path folder = fs::path(EARPOINT_BINARY_DIR) / "installed_models_test";
  fs::create_directories(folder);
  const char* before = std::getenv("EARPOINT_DATA_DIR");
  const std::string kept = before != nullptr ? before : "";
  setenv("EARPOINT_DATA_DIR", folder.c_str(), 1);
  fs::remove(folder / "models.pack");
  EXPECT_FALSE(installed_model_pack());
  EXPECT_TRUE(installed_models().furniture.empty());
  EXPECT_NE(warning_of(installed_models()).find("./dev assets"), std::string::npos);
  write_model_pack(small_pack(), folder / "models.pack");
  EXPECT_EQ(installed_model_pack(), folder / "models.pack");
  EXPECT_EQ(installed_models().furniture.size(), 1U);
  EXPECT_EQ(warning_of(installed_models()), "");
  if (before != nullptr) {
    setenv("EARPOINT_DATA_DIR", kept.c_str(), 1);
  } else {
    unsetenv("EARPOINT_DATA_DIR");
  }
  fs::remove_all(folder);
}

TEST(InstalledModels, FurnishHomesWithinTheirLimits) {
  const ModelPack pack = installed_models();
  if (pack.furniture.empty()) GTEST_SKIP() << "no models are installed; ./dev assets does it";
  for (const FurnitureModel& model : pack.furniture) {
    SCOPED_TRACE(model.name);
    EXPECT_LE(model.scene.mesh.triangles.size(), 10'000U);
    EXPECT_FALSE(model.credit.empty());
    const Bounds box = bounds(model.scene.mesh);
    EXPECT_NEAR(norm(box.high - box.low - model.size_m), 0.0, 1e-4);  // floats
    EXPECT_NEAR(box.low.z, 0.0, 1e-4);
    EXPECT_NEAR(box.low.x + box.high.x, 0.0, 1e-4);
  }
}

}  // namespace
}  // namespace earpoint

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/scene/import.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// The rooms of testdata/make_models.py: 18 m2 of floor, 86 m2 of faces, 45 m3.
constexpr double kFloor_m2 = 18.0;
constexpr double kFaces_m2 = 86.0;
constexpr double kVolume_m3 = 45.0;

class Import : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(EARPOINT_BINARY_DIR) / "import_test" /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    for (const char* name : {"room.obj", "room.mtl", "room.glb", "room.ply", "tiles.png"}) {
      fs::copy_file(fs::path(EARPOINT_SOURCE_DIR) / "lab/scene/testdata" / name, folder_ / name);
    }
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }

  /// @return the message with which a file is refused
  [[nodiscard]] std::string refusal(const std::string& name,
                                    const ImportOptions& options = {}) const {
    try {
      import_scene(file(name), options);
    } catch (const InputError& error) {
      const std::string message = error.what();
      const std::string folder = folder_.string() + "/";
      return message.starts_with(folder) ? message.substr(folder.size()) : message;
    }
    return "accepted";
  }

  void replace(const std::string& name, const std::string& from, const std::string& to) const {
    std::string text = read_text_file(file(name));
    const std::size_t place = text.find(from);
    ASSERT_NE(place, std::string::npos) << from;
    write_file(file(name), std::string_view(text.replace(place, from.size(), to)));
  }

 private:
  fs::path folder_;
};

double area_m2(const Scene& scene, const std::function<bool(std::size_t)>& counts) {
  double sum = 0.0;
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
    if (counts(i)) sum += norm(scaled_normal(scene.mesh, i)) / 2.0;
  }
  return sum;
}

double area_m2(const Scene& scene, const std::string& sound) {
  return area_m2(scene, [&](std::size_t i) {
    return scene.materials[scene.mesh.triangle_material[i]].acoustic.name == sound;
  });
}

/// The volume inside, if all faces look inward.
double enclosed_m3(const Mesh& mesh) {
  double sum = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum -= dot(vertex(mesh, a), cross(vertex(mesh, b), vertex(mesh, c))) / 6.0;
  }
  return sum;
}

void expect_the_room(const Scene& scene) {
  const Bounds box = bounds(scene.mesh);
  // Floats of a few metres, some through a rotation and centimetres.
  EXPECT_NEAR(norm(box.low), 0.0, 1e-5);
  EXPECT_NEAR(norm(box.high - Vector3{6.0, 4.0, 2.5}), 0.0, 1e-5);
  EXPECT_NEAR(area_m2(scene, [](std::size_t) { return true; }), kFaces_m2, 1e-3);
  EXPECT_NEAR(enclosed_m3(scene.mesh), kVolume_m3, 1e-3);
}

TEST_F(Import, ReadsObjWithPolygonsTheirSurfacesAndTexture) {
  const ImportedScene room = import_scene(file("room.obj"));
  expect_the_room(room.scene);
  // Here and below: areas from floats of a few metres, each precise to 1e-6, over some tens of
  // faces.
  EXPECT_NEAR(area_m2(room.scene, "carpet_felt"), kFloor_m2, 1e-3);
  EXPECT_NEAR(area_m2(room.scene, "ceramic_tile"), 6.0 * 2.5, 1e-3);
  EXPECT_EQ(room.scene.textures.size(), 1U);
  EXPECT_EQ(room.report.closure.escaping_share, 0.0);
  EXPECT_GT(room.report.closure.rays, 1000U);
}

TEST_F(Import, TakesASoundFromTheObjectWhereTheMaterialSaysNothing) {
  const ImportedScene room = import_scene(file("room.obj"));
  // "white.001" on "Wall_2" is a wall; on "lid" nothing says what it is.
  EXPECT_NEAR(area_m2(room.scene, "plasterboard_wall"), kFloor_m2 + 14.0 * 2.5, 1e-3);
  ASSERT_EQ(room.report.unknown_surfaces.size(), 1U);
  EXPECT_EQ(room.report.unknown_surfaces.begin()->first, "white.001");
  EXPECT_EQ(room.report.unknown_surfaces.begin()->second, 1U);
  ASSERT_EQ(room.report.warnings().size(), 1U);
  EXPECT_EQ(room.report.warnings()[0],
            "surface 'white.001' (1 faces) matches no pattern and gets the material "
            "plasterboard_wall; name it in the materials");
}

/// The colour of the texture at the corner of a textured face that lies highest.
std::array<int, 3> colour_at_top(const Scene& scene) {
  std::uint32_t top = 0;
  double highest = -1.0;
  const Look* look = nullptr;
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
    const Material& material = scene.materials[scene.mesh.triangle_material[i]];
    if (material.acoustic.name != "ceramic_tile") continue;
    for (const std::uint32_t v : scene.mesh.triangles[i]) {
      if (vertex(scene.mesh, v).z <= highest) continue;
      highest = vertex(scene.mesh, v).z;
      top = v;
      look = &material.look;
    }
  }
  if (look == nullptr || look->texture == Look::kNoTexture) return {-1, -1, -1};
  const Image& texture = scene.textures[static_cast<std::size_t>(look->texture)];
  // v points up: 1 is the picture's first row.
  const float v = scene.mesh.uvs[top][1];
  const int row = std::clamp(static_cast<int>((1.0F - v) * static_cast<float>(texture.height())), 0,
                             texture.height() - 1);
  return {texture.at(0, row, 0), texture.at(0, row, 1), texture.at(0, row, 2)};
}

TEST_F(Import, ReadsGlbWithTransformsOfNodesAndATextureInside) {
  const ImportedScene room = import_scene(file("room.glb"));
  expect_the_room(room.scene);
  EXPECT_NEAR(area_m2(room.scene, "parquet"), kFloor_m2, 1e-3);
  EXPECT_NEAR(area_m2(room.scene, "acoustic_ceiling_tile"), kFloor_m2, 1e-3);
  EXPECT_NEAR(area_m2(room.scene, "brick_open_joints"), 14.0 * 2.5, 1e-3);
  EXPECT_EQ(room.scene.textures.size(), 1U);
  EXPECT_TRUE(room.report.warnings().empty());
  for (const Material& material : room.scene.materials) {
    if (material.acoustic.name != "parquet") continue;
    EXPECT_EQ(material.look.base_colour, (std::array<float, 3>{0.5F, 0.25F, 0.125F}));
  }
}

TEST_F(Import, HangsTexturesUpright) {
  const std::array<int, 3> red = {200, 0, 0};  // the upper half of tiles.png
  EXPECT_EQ(colour_at_top(import_scene(file("room.obj")).scene), red);
  EXPECT_EQ(colour_at_top(import_scene(file("room.glb")).scene), red);
}

TEST_F(Import, ReadsPlyWithTheColoursOfItsVertices) {
  const ImportedScene room = import_scene(file("room.ply"));
  expect_the_room(room.scene);
  ASSERT_EQ(room.scene.textures.size(), 1U);
  const Image& palette = room.scene.textures[0];
  for (std::size_t i = 0; i < room.scene.mesh.triangles.size(); ++i) {
    const auto& triangle = room.scene.mesh.triangles[i];
    if (vertex(room.scene.mesh, triangle[0]).z > 0.1 || scaled_normal(room.scene.mesh, i).z < 0.1) {
      continue;
    }
    const auto& uv = room.scene.mesh.uvs[triangle[0]];
    const int x = static_cast<int>(uv[0] * static_cast<float>(palette.width()));
    const int y = static_cast<int>((1.0F - uv[1]) * static_cast<float>(palette.height()));
    EXPECT_EQ(palette.at(x, y, 0), 120) << "the floor is brown";
    EXPECT_EQ(palette.at(x, y, 2), 30);
  }
  // Its floor is divided where the walls are not: edges are open, but no ray escapes.
  EXPECT_GT(room.report.closure.open_edges, 0U);
  EXPECT_EQ(room.report.closure.escaping_share, 0.0);
}

TEST_F(Import, TurnsAndScalesAsTold) {
  const ImportedScene turned =
      import_scene(file("room.obj"), {.up_axis = UpAxis::z, .unit_m = 2.0});
  const Vector3 high = bounds(turned.scene.mesh).high;
  // The file's y is our y, which was our z before.
  EXPECT_NEAR(norm(high - Vector3{8.0, 5.0, 12.0}), 0.0, 1e-5);
}

TEST_F(Import, FollowsAMaterialTableOfOnesOwn) {
  const MaterialTable table = MaterialTable::parse(R"({
    "format": "earpoint-materials-1", "extends": "standard",
    "patterns": [{"material": "marble", "words": ["white"]}]})",
                                                   "mine.json");
  const ImportedScene room = import_scene(file("room.obj"), {.materials = &table});
  EXPECT_NEAR(area_m2(room.scene, "marble"), kFloor_m2 + 14.0 * 2.5, 1e-3);
  EXPECT_TRUE(room.report.unknown_surfaces.empty());
}

TEST_F(Import, CountsWhatItLeavesOut) {
  const std::string more = "v 1 1 1\nv 2 1 1\nv 3 1 1\nf -1 -2 -3\nl -1 -2\n";
  write_file(file("room.obj"), std::string_view(read_text_file(file("room.obj")) + more));
  fs::remove(file("tiles.png"));
  const ImportedScene room = import_scene(file("room.obj"));
  EXPECT_NEAR(area_m2(room.scene, [](std::size_t) { return true; }), kFaces_m2, 1e-3);
  EXPECT_EQ(room.report.zero_area_triangles, 1U);
  EXPECT_EQ(room.report.missing_textures, std::vector<std::string>{"tiles.png"});
  const std::vector<std::string> warnings = room.report.warnings();
  EXPECT_NE(std::find(warnings.begin(), warnings.end(), "dropped 1 faces without an area"),
            warnings.end());
}

TEST_F(Import, DoubtsTheUnitOfARoomThatIsFarTooHigh) {
  const ImportedScene room = import_scene(file("room.glb"), {.unit_m = 100.0});
  ASSERT_EQ(room.report.warnings().size(), 1U);
  EXPECT_EQ(room.report.warnings()[0],
            "the model is 250 m high; check the length of its unit and which axis points up");
  EXPECT_TRUE(import_scene(file("room.glb")).report.warnings().empty());
}

TEST_F(Import, ReportsAMissingCeilingAndClosesIt) {
  // Without the ceiling, which is the node of index 4.
  replace("room.glb", "\"nodes\":[0,4]", "\"nodes\":[0]  ");
  const ImportedScene open = import_scene(file("room.glb"));
  EXPECT_GT(open.report.closure.escaping_share, 0.1);
  EXPECT_GT(open.report.closure.escaping_up_share, 0.5 * open.report.closure.escaping_share);
  ASSERT_EQ(open.report.warnings().size(), 1U);
  EXPECT_NE(open.report.warnings()[0].find("close the ceiling"), std::string::npos);

  const ImportedScene closed = import_scene(file("room.glb"), {.close_ceiling = true});
  EXPECT_EQ(closed.report.closure.escaping_share, 0.0);
  // A grid of 0.1 m: up to a cell along 20 m of walls.
  EXPECT_NEAR(closed.report.added_ceiling_m2, kFloor_m2, 2.0);
  EXPECT_GT(area_m2(closed.scene, "plasterboard_ceiling"), kFloor_m2);
}

TEST_F(Import, RefusesWhatIsNoSceneInOneLine) {
  write_file(file("empty.obj"), std::string_view("# nothing\n"));
  write_file(file("points.obj"), std::string_view("v 0 0 0\nv 1 0 0\nv 1 1 0\n"));
  write_file(file("noise.glb"), std::string_view("glTF but not really"));
  write_file(file("room.stl"), std::string_view("solid x"));
  EXPECT_EQ(refusal("absent.obj"), "absent.obj: does not exist, or is not a file");
  EXPECT_EQ(refusal("room.stl"),
            "room.stl: expected a .glb, .gltf, .obj or .ply model, found '.stl'; "
            "convert it to .glb");
  for (const char* name : {"empty.obj", "points.obj", "noise.glb"}) {
    const std::string message = refusal(name);
    EXPECT_TRUE(message.starts_with(name)) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_EQ(refusal("room.obj", {.unit_m = -1.0}), "unit: expected a length above 0 m, found -1");
  EXPECT_EQ(refusal("room.obj", {.unit_m = 10000.0}),
            "room.obj: is 60000 m long, expected at most 10000 m; check the unit of length");
  EXPECT_EQ(refusal("room.obj", {.unit_m = 1000.0}),
            "room.obj: is 6000 m in size, expected at most 1000 m; give the length of its unit in "
            "metres: 0.01 if it is in centimetres");
  EXPECT_EQ(
      refusal("room.obj", {.unit_m = 1e-3}),
      "room.obj: is only 0.006 m in size; give the length of its unit in metres: 1000 if it is "
      "in kilometres");
}

TEST_F(Import, RefusesNumbersThatAreNone) {
  replace("room.obj", "v 0 0 6", "v nan 0 6");
  EXPECT_NE(refusal("room.obj").find("is not a finite number"), std::string::npos)
      << refusal("room.obj");
  std::string ply = read_text_file(file("room.ply"));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(ply.data() + ply.find("end_header\n") + 11, &nan, sizeof nan);
  write_file(file("room.ply"), std::string_view(ply));
  EXPECT_NE(refusal("room.ply").find("is not a finite number"), std::string::npos)
      << refusal("room.ply");
}

TEST_F(Import, RefusesAGlbWithANumberThatIsNone) {
  std::string glb = read_text_file(file("room.glb"));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  // The first number behind the second chunk's name is a coordinate of a vertex.
  std::memcpy(glb.data() + glb.find(std::string_view("BIN\0", 4)) + 4, &nan, sizeof nan);
  write_file(file("room.glb"), std::string_view(glb));
  const std::string message = refusal("room.glb");
  EXPECT_TRUE(message.starts_with("room.glb: ")) << message;
  EXPECT_NE(message.find("finite"), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST_F(Import, RefusesMeshesWithoutAFaceThatHasAnArea) {
  constexpr std::string_view kHeader =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\n";
  const std::string header(kHeader);
  const std::string vertices = "0 0 0\n1 0 0\n2 0 0\n";
  write_file(file("none.ply"), std::string_view(header + "end_header\n" + vertices));
  write_file(file("line.ply"),
             std::string_view(header + "element face 1\nproperty list uchar int vertex_indices\n" +
                              "end_header\n" + vertices + "3 0 1 2\n"));
  write_file(file("line.obj"), std::string_view("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"));
  replace("room.glb", "\"nodes\":[0,4]", "\"nodes\":[]   ");
  for (const char* name : {"none.ply", "line.ply", "line.obj", "room.glb"}) {
    const std::string message = refusal(name);
    EXPECT_TRUE(message.starts_with(std::string(name) + ": ")) << message;
    EXPECT_NE(message, "accepted") << name;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_EQ(refusal("line.ply"), "line.ply: has no face with an area; repair the mesh");
  EXPECT_EQ(refusal("line.obj"), "line.obj: has no face with an area; repair the mesh");
}

TEST_F(Import, RefusesModelsLongerThanTenKilometres) {
  for (const char* name : {"room.obj", "room.glb", "room.ply"}) {
    EXPECT_EQ(refusal(name, {.unit_m = 2000.0}),
              std::string(name) +
                  ": is 12000 m long, expected at most 10000 m; check the unit of length");
  }
}

TEST_F(Import, RefusesAGlbWhosePictureHasNoKind) {
  // Assimp 5.2 crashes on this one.
  replace("room.glb", "image/png", "image-png");
  EXPECT_EQ(refusal("room.glb"),
            "room.glb: images[0].mimeType: expected a kind like 'image/png', found 'image-png'");
}

TEST_F(Import, RefusesCutFilesOrReadsThemWhole) {
  for (const char* name : {"room.glb", "room.ply", "room.obj"}) {
    const std::string whole = read_text_file(file(name));
    for (std::size_t length = 0; length < whole.size(); length += 41) {
      write_file(file(name), std::string_view(whole).substr(0, length));
      const std::string message = refusal(name);
      // Text may end anywhere: the rest is read or refused. Binary files state their size.
      if (std::string_view(name) == "room.obj") continue;
      EXPECT_NE(message, "accepted") << name << " cut to " << length << " bytes";
    }
  }
}

/// A box of 6 x 3 x 4 m (y up) whose corners are 16-bit shares of 6 m, 8 bytes apart, as
/// KHR_mesh_quantization allows.
/// @param count  of vertices, as the accessor claims; there are 8
std::string quantised_box(int count, const std::string& more = "") {
  const std::string json =
      R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_mesh_quantization"],)"
      R"("extensionsRequired":["KHR_mesh_quantization")" +
      more +
      R"(],)"
      R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"scale":[6,6,6]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5123,"normalized":true,"type":"VEC3","count":)" +
      std::to_string(count) +
      R"(,"min":[0,0,0],"max":[65535,32768,43690]},)"
      R"({"bufferView":1,"componentType":5123,"type":"SCALAR","count":36}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":64,"byteStride":8},)"
      R"({"buffer":0,"byteOffset":64,"byteLength":72}],"buffers":[{"byteLength":136}]})";
  std::vector<std::uint16_t> data;
  for (int corner = 0; corner < 8; ++corner) {
    data.insert(data.end(), {static_cast<std::uint16_t>((corner & 1) != 0 ? 65535 : 0),
                             static_cast<std::uint16_t>((corner & 2) != 0 ? 32768 : 0),
                             static_cast<std::uint16_t>((corner & 4) != 0 ? 43690 : 0), 0});
  }
  for (const int index : {0, 1, 3, 0, 3, 2, 4, 7, 5, 4, 6, 7, 0, 5, 1, 0, 4, 5,
                          2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3}) {
    data.push_back(static_cast<std::uint16_t>(index));
  }
  std::string text = json + std::string((4 - json.size() % 4) % 4, ' ');
  const auto word = [](std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&number), sizeof number);
  };
  const std::string bytes(reinterpret_cast<const char*>(data.data()), 2 * data.size());
  return "glTF" + word(2) + word(28 + text.size() + bytes.size()) + word(text.size()) + "JSON" +
         text + word(bytes.size()) + std::string("BIN\0", 4) + bytes;
}

TEST_F(Import, CoordinatesMayBeSmallIntegers) {
  write_file(file("box.glb"), std::string_view(quantised_box(8)));
  const Scene scene = import_scene(file("box.glb")).scene;
  EXPECT_EQ(scene.mesh.triangles.size(), 12U);
  const Bounds box = bounds(scene.mesh);
  // File x is our y, file y our z, file z our x; 16 bits of 6 m are 0.1 mm.
  EXPECT_NEAR(box.high.y - box.low.y, 6.0, 2e-4);
  EXPECT_NEAR(box.high.z - box.low.z, 3.0, 2e-4);
  EXPECT_NEAR(box.high.x - box.low.x, 4.0, 2e-4);
}

TEST_F(Import, RefusesIntegersThatAreNotThereAndPackedMeshes) {
  write_file(file("box.glb"), std::string_view(quantised_box(80)));
  EXPECT_EQ(refusal("box.glb"),
            "box.glb: accessors[0]: points outside the file's data; export it again");
  write_file(file("box.glb"), std::string_view(quantised_box(8, R"(,"EXT_meshopt_compression")")));
  EXPECT_EQ(
      refusal("box.glb"),
      "box.glb: is compressed by meshopt, which is not supported; export it without compression");
}

TEST_F(Import, MovesAModelThatLiesFarFromItsOrigin) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "far.obj";
  write_file(path, std::string_view("v 500000 5800000 100\nv 500006 5800000 100\n"
                                    "v 500006 5800005 100\nv 500000 5800005 103\n"
                                    "f 1 2 3\nf 1 3 4\n"));
  const ImportedScene imported = import_scene(path, {.up_axis = UpAxis::z});
  std::filesystem::remove(path);
  EXPECT_EQ(imported.origin_m, (Vector3{500000.0, 5800000.0, 100.0}));
  const Bounds box = bounds(imported.scene.mesh);
  EXPECT_EQ(box.low, (Vector3{0.0, 0.0, 0.0}));
  EXPECT_EQ(box.high, (Vector3{6.0, 5.0, 3.0}));
  // A float of 5.8 million has steps of half a metre.
  EXPECT_EQ(imported.report.coordinate_step_m, 0.5);
  const std::vector<std::string> lines = imported.report.warnings();
  EXPECT_TRUE(std::ranges::any_of(lines, [](const std::string& line) {
    return line.find("precision is only 0.5 m") != std::string::npos;
  }));
}

TEST_F(Import, LeavesAModelNearItsOriginWhereItIs) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "near.obj";
  write_file(path, std::string_view("v 20 30 1\nv 26 30 1\nv 26 35 1\nf 1 2 3\n"));
  const ImportedScene imported = import_scene(path, {.up_axis = UpAxis::z});
  std::filesystem::remove(path);
  EXPECT_EQ(imported.origin_m, (Vector3{0.0, 0.0, 0.0}));
  EXPECT_EQ(bounds(imported.scene.mesh).low, (Vector3{20.0, 30.0, 1.0}));
}

}  // namespace
}  // namespace earpoint

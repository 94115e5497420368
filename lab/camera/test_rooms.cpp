#include "test_rooms.h"

#include <cmath>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

std::uint32_t add_look(Scene& scene, const std::string& name, InstanceKind kind, const Look& look) {
  Material material{.acoustic = {}, .look = look};
  material.acoustic.name = name;
  scene.materials.push_back(material);
  scene.instances.push_back({.name = name, .kind = kind});
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

void add_triangle(Scene& scene, std::array<std::uint32_t, 3> corners, std::uint32_t material) {
  scene.mesh.triangles.push_back(corners);
  scene.mesh.triangle_material.push_back(material);
  scene.mesh.triangle_instance.push_back(static_cast<std::uint32_t>(scene.instances.size() - 1));
}

// Fills missing normals and texture coordinates, so that the arrays keep the same length.
void pad_vertices(Scene& scene) {
  scene.mesh.normals.resize(scene.mesh.positions.size());
  scene.mesh.uvs.resize(scene.mesh.positions.size());
}

void add_face(Scene& scene, const Vector3& corner, const Vector3& along, const Vector3& across,
              std::array<float, 2> repeat, std::uint32_t material) {
  pad_vertices(scene);
  const auto first = static_cast<std::uint32_t>(scene.mesh.positions.size());
  const Vector3 normal = normalized(cross(along, across));
  for (int i = 0; i < 4; ++i) {
    const double a = (i == 1 || i == 2) ? 1.0 : 0.0;
    const double b = i >= 2 ? 1.0 : 0.0;
    const Vector3 p = corner + along * a + across * b;
    scene.mesh.positions.push_back(
        {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    scene.mesh.normals.push_back(
        {static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)});
    scene.mesh.uvs.push_back(
        {static_cast<float>(a) * repeat[0], static_cast<float>(b) * repeat[1]});
  }
  add_triangle(scene, {first, first + 1, first + 2}, material);
  add_triangle(scene, {first, first + 2, first + 3}, material);
}

// Planks of wood, each with its own tone and grain.
Image planks() {
  constexpr int kSize = 256;
  constexpr int kPlanks = 8;
  Image picture(kSize, kSize, 3);
  RandomStream random(5);
  std::array<double, kPlanks> tone{};
  std::array<double, kPlanks> phase{};
  for (int i = 0; i < kPlanks; ++i) {
    tone[i] = random.uniform(0.75, 1.05);
    phase[i] = random.uniform(0.0, 50.0);
  }
  for (int y = 0; y < kSize; ++y) {
    const int plank = y * kPlanks / kSize;
    const bool gap = y % (kSize / kPlanks) == 0;
    for (int x = 0; x < kSize; ++x) {
      const double grain = 0.04 * std::sin(0.9 * y + 3.0 * std::sin(0.05 * x + phase[plank]));
      const double level = gap ? 0.35 : tone[plank] + grain;
      picture.at(x, y, 0) = static_cast<std::uint8_t>(std::min(255.0, 176 * level));
      picture.at(x, y, 1) = static_cast<std::uint8_t>(std::min(255.0, 128 * level));
      picture.at(x, y, 2) = static_cast<std::uint8_t>(std::min(255.0, 84 * level));
    }
  }
  return picture;
}

Image weave(std::array<int, 3> colour) {
  constexpr int kSize = 64;
  Image picture(kSize, kSize, 3);
  RandomStream random(7);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double level = random.uniform(0.75, 1.1);
      for (int c = 0; c < 3; ++c) {
        picture.at(x, y, c) = static_cast<std::uint8_t>(std::min(255.0, colour[c] * level));
      }
    }
  }
  return picture;
}

void furnish(Scene& scene) {
  const Look wood{.base_colour = {0.30F, 0.18F, 0.10F}, .roughness = 0.35F};
  const Look cloth = plain_look(0.12F, 0.20F, 0.30F);
  const Look white = plain_look(0.75F, 0.75F, 0.72F);
  const Look chrome{.base_colour = {0.8F, 0.8F, 0.8F}, .roughness = 0.02F, .metallic = 1.0F};
  using enum InstanceKind;
  add_rectangle(scene, "carpet", {1.8, 1.2, 0.004}, {2.4, 0, 0}, {0, 1.8, 0},
                {.base_colour = {1, 1, 1}, .texture = 1, .roughness = 1.0F}, {12, 9});
  add_box(scene, "sofa seat", furniture, {1.6, 3.5, 0.15}, {3.8, 4.4, 0.45}, cloth);
  add_box(scene, "sofa back", furniture, {1.6, 4.15, 0.45}, {3.8, 4.4, 0.9}, cloth);
  add_box(scene, "sofa arm", furniture, {1.4, 3.5, 0.15}, {1.6, 4.4, 0.65}, cloth);
  add_box(scene, "sofa arm", furniture, {3.8, 3.5, 0.15}, {4.0, 4.4, 0.65}, cloth);
  add_box(scene, "table top", furniture, {2.2, 1.7, 0.40}, {3.6, 2.5, 0.44}, wood);
  for (const double x : {2.25, 3.5}) {
    for (const double y : {1.75, 2.4}) {
      add_box(scene, "table leg", furniture, {x, y, 0.0}, {x + 0.05, y + 0.05, 0.40}, wood);
    }
  }
  add_ball(scene, "bowl", {2.9, 2.1, 0.56}, 0.12, 16,
           {.base_colour = {0.7F, 0.1F, 0.08F}, .roughness = 0.15F});
  add_box(scene, "shelf", furniture, {5.0, 0.05, 0.0}, {5.9, 0.40, 1.9}, white);
  for (int board = 0; board < 4; ++board) {
    add_box(scene, "book", furniture, {5.05, 0.40, 0.15 + 0.42 * board},
            {5.35 + 0.1 * board, 0.42, 0.40 + 0.42 * board}, plain_look(0.4F, 0.1F, 0.05F));
  }
  add_rectangle(scene, "mirror", {0.02, 3.0, 0.6}, {0, -1.0, 0}, {0, 0, 1.2}, chrome);
}

}  // namespace

Look plain_look(float red, float green, float blue) {
  return {.base_colour = {red, green, blue}, .roughness = 0.9F};
}

int add_box(Scene& scene, const std::string& name, InstanceKind kind, const Vector3& low,
            const Vector3& high, const Look& look) {
  const std::uint32_t material = add_look(scene, name, kind, look);
  const Vector3 x{high.x - low.x, 0, 0};
  const Vector3 y{0, high.y - low.y, 0};
  const Vector3 z{0, 0, high.z - low.z};
  const std::array<float, 2> once{1.0F, 1.0F};
  add_face(scene, low, z, y, once, material);
  add_face(scene, low, x, z, once, material);
  add_face(scene, low, y, x, once, material);
  add_face(scene, low + x, y, z, once, material);
  add_face(scene, low + y, z, x, once, material);
  add_face(scene, low + z, x, y, once, material);
  return static_cast<int>(scene.instances.size()) - 1;
}

int add_ball(Scene& scene, const std::string& name, const Vector3& centre, double radius_m,
             int rings, const Look& look) {
  const std::uint32_t material = add_look(scene, name, InstanceKind::furniture, look);
  pad_vertices(scene);
  const auto first = static_cast<std::uint32_t>(scene.mesh.positions.size());
  const int sectors = 2 * rings;
  for (int ring = 0; ring <= rings; ++ring) {
    for (int sector = 0; sector <= sectors; ++sector) {
      const Vector3 out = cartesian_from_spherical({.azimuth_rad = 2.0 * kPi * sector / sectors,
                                                    .elevation_rad = kPi * ring / rings - kPi / 2,
                                                    .distance_m = 1.0});
      const Vector3 p = centre + out * radius_m;
      scene.mesh.positions.push_back(
          {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
      scene.mesh.normals.push_back(
          {static_cast<float>(out.x), static_cast<float>(out.y), static_cast<float>(out.z)});
      scene.mesh.uvs.push_back({static_cast<float>(sector) / static_cast<float>(sectors),
                                static_cast<float>(ring) / static_cast<float>(rings)});
    }
  }
  const auto row = static_cast<std::uint32_t>(sectors + 1);
  for (std::uint32_t ring = 0; ring < static_cast<std::uint32_t>(rings); ++ring) {
    for (std::uint32_t sector = 0; sector + 1 < row; ++sector) {
      const std::uint32_t a = first + ring * row + sector;
      // At the poles one of the two triangles has no area.
      if (ring > 0) add_triangle(scene, {a, a + 1, a + row}, material);
      if (ring + 1 < static_cast<std::uint32_t>(rings)) {
        add_triangle(scene, {a + 1, a + row + 1, a + row}, material);
      }
    }
  }
  return static_cast<int>(scene.instances.size()) - 1;
}

int add_rectangle(Scene& scene, const std::string& name, const Vector3& corner,
                  const Vector3& along, const Vector3& across, const Look& look,
                  std::array<float, 2> repeat) {
  const std::uint32_t material = add_look(scene, name, InstanceKind::structure, look);
  add_face(scene, corner, along, across, repeat, material);
  return static_cast<int>(scene.instances.size()) - 1;
}

Scene furnished_room() {
  Scene scene;
  scene.textures = {planks(), weave({150, 60, 50})};
  const Look wall = plain_look(0.72F, 0.70F, 0.64F);
  const Look ceiling = plain_look(0.85F, 0.85F, 0.85F);
  const Look floor{.base_colour = {1, 1, 1}, .texture = 0, .roughness = 0.4F};
  add_rectangle(scene, "floor", {0, 0, 0}, {6, 0, 0}, {0, 4.5, 0}, floor, {6, 4.5});
  add_rectangle(scene, "ceiling", {0, 0, 2.6}, {0, 4.5, 0}, {6, 0, 0}, ceiling);
  add_rectangle(scene, "wall x low", {0, 0, 0}, {0, 4.5, 0}, {0, 0, 2.6}, wall);
  add_rectangle(scene, "wall y low", {0, 0, 0}, {0, 0, 2.6}, {6, 0, 0}, wall);
  add_rectangle(scene, "wall y high", {0, 4.5, 0}, {6, 0, 0}, {0, 0, 2.6}, wall);
  // The wall x = 6 m around a window with a bright sky behind it.
  add_rectangle(scene, "wall under", {6, 0, 0}, {0, 0, 0.9}, {0, 4.5, 0}, wall);
  add_rectangle(scene, "wall over", {6, 0, 2.1}, {0, 0, 0.5}, {0, 4.5, 0}, wall);
  add_rectangle(scene, "wall right", {6, 0, 0.9}, {0, 0, 1.2}, {0, 1.5, 0}, wall);
  add_rectangle(scene, "wall left", {6, 3.2, 0.9}, {0, 0, 1.2}, {0, 1.3, 0}, wall);
  add_rectangle(scene, "sky", {6.03, 1.5, 0.9}, {0, 0, 1.2}, {0, 1.7, 0},
                {.base_colour = {0.1F, 0.1F, 0.1F}, .emission = {5.0F, 5.6F, 6.4F}});
  const Look frame = plain_look(0.85F, 0.85F, 0.82F);
  using enum InstanceKind;
  add_box(scene, "frame", structure, {5.94, 1.5, 0.88}, {6.06, 3.2, 0.94}, frame);
  add_box(scene, "frame", structure, {5.94, 1.5, 2.06}, {6.06, 3.2, 2.12}, frame);
  add_box(scene, "frame", structure, {5.94, 1.47, 0.88}, {6.06, 1.53, 2.12}, frame);
  add_box(scene, "frame", structure, {5.94, 3.17, 0.88}, {6.06, 3.23, 2.12}, frame);
  add_box(scene, "frame", structure, {5.96, 2.32, 0.88}, {6.04, 2.38, 2.12}, frame);
  furnish(scene);
  scene.lamps.push_back(
      {.position_m = {3.0, 2.2, 2.3}, .intensity = {1.6F, 1.35F, 1.0F}, .radius_m = 0.12F});
  check_scene(scene, "furnished room");
  return scene;
}

}  // namespace earpoint

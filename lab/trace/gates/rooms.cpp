#include "rooms.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace earpoint::gates {
namespace {

void add_mesh(Scene& scene, const std::vector<std::array<float, 3>>& positions,
              const std::vector<std::array<std::uint32_t, 3>>& triangles,
              const AcousticMaterial& material) {
  const auto first_vertex = static_cast<std::uint32_t>(scene.mesh.positions.size());
  scene.mesh.positions.insert(scene.mesh.positions.end(), positions.begin(), positions.end());
  for (const auto& [a, b, c] : triangles) {
    scene.mesh.triangles.push_back({a + first_vertex, b + first_vertex, c + first_vertex});
  }
  const auto material_index = static_cast<std::uint32_t>(scene.materials.size());
  const auto instance_index = static_cast<std::uint32_t>(scene.instances.size());
  scene.materials.push_back({.acoustic = material, .look = {}});
  scene.instances.push_back({.name = material.name, .kind = InstanceKind::structure});
  scene.mesh.triangle_material.insert(scene.mesh.triangle_material.end(), triangles.size(),
                                      material_index);
  scene.mesh.triangle_instance.insert(scene.mesh.triangle_instance.end(), triangles.size(),
                                      instance_index);
}

std::array<float, 3> position(const Vector3& point) {
  return {static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z)};
}

}  // namespace

Source omni(const Vector3& position_m) {
  return {.world_from_source = {.position_m = position_m, .orientation = {}}};
}

void add_block(Scene& scene, const Vector3& low, const Vector3& high,
               const AcousticMaterial& material) {
  Scene block = make_shoebox(high - low, all_bands(0.0F), all_bands(0.0F));
  for (auto& [x, y, z] : block.mesh.positions) {
    x += static_cast<float>(low.x);
    y += static_cast<float>(low.y);
    z += static_cast<float>(low.z);
  }
  for (auto& triangle : block.mesh.triangles) std::swap(triangle[1], triangle[2]);
  add_mesh(scene, block.mesh.positions, block.mesh.triangles, material);
}

void add_panel(Scene& scene, const Vector3& corner, const Vector3& along, const Vector3& up,
               const AcousticMaterial& material) {
  add_mesh(scene,
           {position(corner), position(corner + along), position(corner + along + up),
            position(corner + up)},
           {{0, 1, 2}, {0, 2, 3}}, material);
}

Scene wall_with_door(Door door, double thickness_m) {
  Scene scene = open_air();
  if (door == Door::none) return scene;
  const AcousticMaterial rigid{.name = "wall",
                               .absorption = all_bands(0.0F),
                               .scattering = all_bands(0.0F),
                               .transmission = {},
                               .source = {}};
  const AcousticMaterial leaf{.name = "door",
                              .absorption = all_bands(1.0F),
                              .scattering = all_bands(0.0F),
                              .transmission = all_bands(1.0F / 3000.0F),
                              .source = {}};
  // Left of the door, right of it, above and below.
  const std::array<std::array<double, 4>, 4> parts = {
      {{-30, 0, -30, 30}, {1, 30, -30, 30}, {0, 1, 2, 30}, {0, 1, -30, 0}}};
  for (const auto& [y_low, y_high, z_low, z_high] : parts) {
    if (thickness_m > 0.0) {
      add_block(scene, {0, y_low, z_low}, {thickness_m, y_high, z_high}, rigid);
    } else {
      add_panel(scene, {0, y_low, z_low}, {0, y_high - y_low, 0}, {0, 0, z_high - z_low}, rigid);
    }
  }
  if (door == Door::closed) add_panel(scene, {0, 0, 0}, {0, 1, 0}, {0, 0, 2}, leaf);
  return scene;
}

Scene open_air() {
  Scene scene = make_shoebox({100, 100, 100}, all_bands(1.0F), all_bands(0.0F));
  for (auto& [x, y, z] : scene.mesh.positions) {
    x -= 50.0F;
    y -= 50.0F;
    z -= 50.0F;
  }
  return scene;
}

Scene obstacle_room() {
  std::array<AcousticMaterial, 6> faces;
  const std::array<float, 6> absorption = {0.1F, 0.3F, 0.15F, 0.25F, 0.4F, 0.2F};
  const std::array<float, 6> scattering = {0.1F, 0.5F, 0.2F, 0.3F, 0.6F, 0.2F};
  for (int i = 0; i < 6; ++i) {
    faces[i].name = "wall";
    for (int band = 0; band < kOctaveBands; ++band) {
      // The walls change places from band to band.
      faces[i].absorption[band] = absorption[(i + band) % 6];
      faces[i].scattering[band] = scattering[(i + band) % 6];
    }
  }
  Scene scene = make_shoebox({6, 5, 3}, faces);
  add_block(scene, {2, 2, 0}, {4.5, 2.2, 3},
            {.name = "partition",
             .absorption = all_bands(0.1F),
             .scattering = all_bands(0.3F),
             .transmission = {},
             .source = {}});
  return scene;
}

}  // namespace earpoint::gates

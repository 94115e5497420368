#include "rooms.h"

#include <cstdint>

namespace earpoint::gates {

Source omni(const Vector3& position_m) {
  return {.world_from_source = {.position_m = position_m, .orientation = {}}};
}

void add_block(Scene& scene, const Vector3& low, const Vector3& high,
               const AcousticMaterial& material) {
  const Vector3 size = high - low;
  Scene block = make_shoebox(size, all_bands(0.0F), all_bands(0.0F));
  const auto first_vertex = static_cast<std::uint32_t>(scene.mesh.positions.size());
  for (const auto& [x, y, z] : block.mesh.positions) {
    scene.mesh.positions.push_back({x + static_cast<float>(low.x), y + static_cast<float>(low.y),
                                    z + static_cast<float>(low.z)});
  }
  for (const auto& [a, b, c] : block.mesh.triangles) {
    scene.mesh.triangles.push_back({a + first_vertex, c + first_vertex, b + first_vertex});
  }
  const auto count = block.mesh.triangles.size();
  const auto material_index = static_cast<std::uint32_t>(scene.materials.size());
  const auto instance_index = static_cast<std::uint32_t>(scene.instances.size());
  scene.materials.push_back({.acoustic = material, .look = {}});
  scene.instances.push_back({.name = material.name, .kind = InstanceKind::structure});
  scene.mesh.triangle_material.insert(scene.mesh.triangle_material.end(), count, material_index);
  scene.mesh.triangle_instance.insert(scene.mesh.triangle_instance.end(), count, instance_index);
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

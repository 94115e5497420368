#include <earpoint/scene/scene.h>

#include <cmath>
#include <cstdint>

#include <fmt/core.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kLargestExtent_m = 10'000.0;

void check_lengths(const Scene& scene, std::string_view where) {
  const Mesh& mesh = scene.mesh;
  const std::size_t faces = mesh.triangles.size();
  const std::size_t vertices = mesh.positions.size();
  if (faces == 0) throw InputError(where, "has no faces", "export it with its triangles");
  const auto expect = [&](const char* field, std::size_t found, std::size_t expected) {
    if (found == expected) return;
    throw InputError(where, fmt::format("{} has {} entries, expected {}", field, found, expected));
  };
  expect("triangle_material", mesh.triangle_material.size(), faces);
  expect("triangle_instance", mesh.triangle_instance.size(), faces);
  if (!mesh.normals.empty()) expect("normals", mesh.normals.size(), vertices);
  if (!mesh.uvs.empty()) expect("uvs", mesh.uvs.size(), vertices);
}

void check_positions(const Mesh& mesh, std::string_view where) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    for (const float value : mesh.positions[i]) {
      if (std::isfinite(value)) continue;
      throw InputError(where, fmt::format("vertex {} is not a finite number", i),
                       "repair the mesh");
    }
  }
  const Bounds box = bounds(mesh);
  const Vector3 extent = box.high - box.low;
  for (const double length_m : {extent.x, extent.y, extent.z}) {
    if (length_m <= kLargestExtent_m) continue;
    throw InputError(
        where,
        fmt::format("is {:.0f} m long, expected at most {:.0f} m", length_m, kLargestExtent_m),
        "check the unit of length");
  }
}

void check_indices(const Scene& scene, std::string_view where) {
  const Mesh& mesh = scene.mesh;
  const auto expect = [&](std::size_t face, const char* what, std::size_t index,
                          std::size_t count) {
    if (index < count) return;
    throw InputError(where,
                     fmt::format("face {} has {} {}, but there are {}", face, what, index, count));
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) expect(i, "vertex", v, mesh.positions.size());
    expect(i, "material", mesh.triangle_material[i], scene.materials.size());
    expect(i, "instance", mesh.triangle_instance[i], scene.instances.size());
  }
}

void check_materials(const Scene& scene, std::string_view where) {
  for (const Material& material : scene.materials) {
    const AcousticMaterial& acoustic = material.acoustic;
    const auto expect = [&](const char* what, const BandArray& values) {
      for (const float value : values) {
        if (value >= 0.0F && value <= 1.0F) continue;
        throw InputError(where, fmt::format("material '{}': {} {} is outside [0, 1]", acoustic.name,
                                            what, value));
      }
    };
    expect("absorption", acoustic.absorption);
    expect("scattering", acoustic.scattering);
    expect("transmission", acoustic.transmission);
    for (int band = 0; band < kOctaveBands; ++band) {
      if (acoustic.transmission[band] <= acoustic.absorption[band]) continue;
      throw InputError(
          where,
          fmt::format("material '{}': transmission {} is above absorption {}", acoustic.name,
                      acoustic.transmission[band], acoustic.absorption[band]),
          "absorption includes transmission");
    }
    const int texture = material.look.texture;
    if (texture != Look::kNoTexture &&
        (texture < 0 || static_cast<std::size_t>(texture) >= scene.textures.size())) {
      throw InputError(where, fmt::format("material '{}': texture {} of {}", acoustic.name, texture,
                                          scene.textures.size()));
    }
  }
}

std::size_t drop_zero_area_triangles(Mesh& mesh) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (norm(scaled_normal(mesh, i)) == 0.0) continue;
    mesh.triangles[kept] = mesh.triangles[i];
    mesh.triangle_material[kept] = mesh.triangle_material[i];
    mesh.triangle_instance[kept] = mesh.triangle_instance[i];
    ++kept;
  }
  const std::size_t dropped = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  mesh.triangle_material.resize(kept);
  mesh.triangle_instance.resize(kept);
  return dropped;
}

}  // namespace

SceneCheck check_scene(Scene& scene, std::string_view where) {
  check_lengths(scene, where);
  check_positions(scene.mesh, where);
  check_indices(scene, where);
  check_materials(scene, where);
  SceneCheck check;
  check.zero_area_triangles = drop_zero_area_triangles(scene.mesh);
  if (scene.mesh.triangles.empty()) {
    throw InputError(where, "has no face with an area", "repair the mesh");
  }
  return check;
}

Scene make_shoebox(const Vector3& lengths_m, const BandArray& absorption,
                   const BandArray& scattering) {
  std::array<AcousticMaterial, 6> faces;
  faces.fill({.name = "wall",
              .absorption = absorption,
              .scattering = scattering,
              .transmission = {},
              .source = "given"});
  return make_shoebox(lengths_m, faces);
}

Scene make_shoebox(const Vector3& lengths_m, const std::array<AcousticMaterial, 6>& faces) {
  EARPOINT_CHECK(lengths_m.x > 0.0 && lengths_m.y > 0.0 && lengths_m.z > 0.0);
  Scene scene;
  scene.instances.push_back({.name = "shoebox", .kind = InstanceKind::structure});
  // Corner 4 z + 2 y + x, where a letter is 1 at the high end; each face's loop turns
  // counter-clockwise when seen from inside.
  for (int corner = 0; corner < 8; ++corner) {
    scene.mesh.positions.push_back({(corner & 1) != 0 ? static_cast<float>(lengths_m.x) : 0.0F,
                                    (corner & 2) != 0 ? static_cast<float>(lengths_m.y) : 0.0F,
                                    (corner & 4) != 0 ? static_cast<float>(lengths_m.z) : 0.0F});
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kLoops = {
      {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}}};
  for (std::uint32_t face = 0; face < 6; ++face) {
    scene.materials.push_back({.acoustic = faces[face], .look = {}});
    const auto& [a, b, c, d] = kLoops[face];
    scene.mesh.triangles.push_back({a, b, c});
    scene.mesh.triangles.push_back({a, c, d});
    scene.mesh.triangle_material.insert(scene.mesh.triangle_material.end(), 2, face);
    scene.mesh.triangle_instance.insert(scene.mesh.triangle_instance.end(), 2, 0);
  }
  return scene;
}

}  // namespace earpoint

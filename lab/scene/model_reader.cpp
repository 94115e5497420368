#include "model_reader.h"

#include "colour_palette.h"
#include "ply.h"
#include "polygon.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include <earpoint/pose.h>
#include <earpoint/scene/texture.h>

namespace earpoint {
namespace {

/// The cosine of 40 degrees: sharper edges stay edges where normals are missing.
constexpr double kCrease = 0.766;

bool has_normal(const Mesh& mesh, std::uint32_t v) {
  const auto& n = mesh.normals[v];
  const double length = norm(Vector3{n[0], n[1], n[2]});
  return std::isfinite(length) && length > 0.0;
}

void set_normal(Mesh& mesh, std::uint32_t v, const Vector3& normal) {
  const double length = norm(normal);
  const Vector3 unit = length > 0.0 ? normal / length : Vector3{0, 0, 1};
  mesh.normals[v] = {static_cast<float>(unit.x), static_cast<float>(unit.y),
                     static_cast<float>(unit.z)};
}

}  // namespace

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; }, ' ');
  return text;
}

std::array<float, 3> to_our_frame(const std::array<double, 3>& v, UpAxis up_axis, double scale) {
  const auto scaled = [&](double x) { return static_cast<float>(x * scale); };
  if (up_axis == UpAxis::z) return {scaled(v[0]), scaled(v[1]), scaled(v[2])};
  return {scaled(v[2]), scaled(v[0]), scaled(v[1])};
}

void mend_normals(Mesh& mesh) {
  // Faces meet where their corners lie at the same place, whether or not they share a vertex.
  std::map<std::array<float, 3>, std::vector<std::size_t>> faces_at;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) {
      if (!has_normal(mesh, v)) faces_at[mesh.positions[v]].push_back(i);
    }
  }
  std::vector<char> done(mesh.positions.size(), 0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vector3 own = scaled_normal(mesh, i);
    for (const std::uint32_t v : mesh.triangles[i]) {
      if (done[v] != 0) continue;
      done[v] = 1;
      if (has_normal(mesh, v)) {
        const auto& n = mesh.normals[v];
        set_normal(mesh, v, {n[0], n[1], n[2]});
        continue;
      }
      Vector3 sum;
      const auto faces = faces_at.find(mesh.positions[v]);
      for (const std::size_t face :
           faces == faces_at.end() ? std::vector<std::size_t>{i} : faces->second) {
        const Vector3 other = scaled_normal(mesh, face);
        if (dot(own, other) >= kCrease * norm(own) * norm(other)) sum = sum + other;
      }
      set_normal(mesh, v, sum);
    }
  }
}

ImportedScene read_ply_scene(const std::filesystem::path& path, const ImportOptions& options,
                             UpAxis up_axis) {
  const PlyModel model = read_ply(path);
  ImportedScene result;
  result.report.points_and_lines = model.small_faces;
  const std::string name = one_line(path.stem().string());
  const MaterialTable& table =
      options.materials != nullptr ? *options.materials : standard_materials();
  const MaterialTable::Match sound = table.match(name);
  result.report.sounds[name] = sound.material->name;
  if (sound.is_default) result.report.unknown_surfaces[name] = model.polygons.size();
  Scene& scene = result.scene;
  scene.instances.push_back({.name = name, .kind = InstanceKind::structure});
  scene.materials.push_back({.acoustic = *sound.material, .look = {}});
  ColourPalette palette;
  const bool coloured = !model.colours.empty();
  for (const std::vector<std::uint32_t>& polygon : model.polygons) {
    std::vector<Vector3> corners;
    const auto first = static_cast<std::uint32_t>(scene.mesh.positions.size());
    std::array<float, 3> colour{};
    for (const std::uint32_t v : polygon) {
      const auto& p = model.positions[v];
      scene.mesh.positions.push_back(to_our_frame({p[0], p[1], p[2]}, up_axis, options.unit_m));
      const std::array<float, 3> n =
          model.normals.empty() ? std::array<float, 3>{} : model.normals[v];
      scene.mesh.normals.push_back(to_our_frame({n[0], n[1], n[2]}, up_axis, 1.0));
      scene.mesh.uvs.push_back(model.uvs.empty() ? std::array<float, 2>{} : model.uvs[v]);
      corners.push_back(vertex(scene.mesh, first + static_cast<std::uint32_t>(corners.size())));
      for (std::size_t k = 0; coloured && k < 3; ++k) {
        colour[k] += model.colours[v][k] / static_cast<float>(polygon.size());
      }
    }
    if (coloured) palette.add(colour);
    for (const auto& [a, b, c] : triangulate(corners)) {
      scene.mesh.triangles.push_back({first + a, first + b, first + c});
    }
  }
  scene.mesh.triangle_material.assign(scene.mesh.triangles.size(), 0);
  scene.mesh.triangle_instance.assign(scene.mesh.triangles.size(), 0);
  if (coloured) {
    std::uint32_t corner = 0;
    for (std::uint32_t pixel = 0; pixel < model.polygons.size(); ++pixel) {
      for (std::size_t i = 0; i < model.polygons[pixel].size(); ++i) {
        scene.mesh.uvs[corner++] = palette.uv(pixel);
      }
    }
    scene.materials[0].look.base_colour = {1.0F, 1.0F, 1.0F};
    scene.materials[0].look.texture = 0;
    scene.textures.push_back(palette.texture());
  }
  mend_normals(scene.mesh);
  return result;
}

}  // namespace earpoint

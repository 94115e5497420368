#include "surfaces.h"

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>

namespace earpoint {
namespace {

// With a reflectance of 1 the light in a closed room would grow without limit.
constexpr float kLargestReflectance = 0.95F;

Rgb clamp_colour(const Rgb& c, float high) {
  return {std::clamp(c.x, 0.0F, high), std::clamp(c.y, 0.0F, high), std::clamp(c.z, 0.0F, high)};
}

}  // namespace

Surfaces::Surfaces(const Scene& scene) { append(scene); }

Surfaces::Surfaces(const Surfaces& base, const Scene& scene) : Surfaces(base) {
  const auto begins_alike = [](const auto& part, const auto& whole) {
    return whole.size() >= part.size() && std::equal(part.begin(), part.end(), whole.begin());
  };
  EARPOINT_CHECK(begins_alike(base.triangles_, scene.mesh.triangles));
  EARPOINT_CHECK(begins_alike(base.triangle_material_, scene.mesh.triangle_material));
  EARPOINT_CHECK(scene.mesh.positions.size() >= base.positions_.size());
  EARPOINT_CHECK(scene.materials.size() >= base.materials_.size());
  EARPOINT_CHECK(scene.textures.size() >= base.textures_.size());
  append(scene);
}

void Surfaces::append(const Scene& scene) {
  const Mesh& mesh = scene.mesh;
  EARPOINT_CHECK(!mesh.triangles.empty());
  EARPOINT_CHECK(mesh.triangle_material.size() == mesh.triangles.size());
  EARPOINT_CHECK(mesh.triangle_instance.size() == mesh.triangles.size());
  float extent = 1.0F;
  const std::size_t known = positions_.size();
  positions_.resize(mesh.positions.size());
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (i >= known) positions_[i] = float3(mesh.positions[i]);
    extent = std::max(extent, largest({std::abs(positions_[i].x), std::abs(positions_[i].y),
                                       std::abs(positions_[i].z)}));
  }
  // Far above the rounding of positions, far below what can be seen.
  start_offset_m_ = 1e-4F + 4e-6F * extent;
  for (std::size_t i = normals_.size(); i < mesh.normals.size(); ++i) {
    normals_.push_back(float3(mesh.normals[i]));
  }
  for (std::size_t i = uvs_.size(); i < mesh.uvs.size(); ++i) {
    uvs_.push_back(mesh.uvs[i]);
    for (float& value : uvs_.back()) value = std::isfinite(value) ? value : 0.0F;
  }
  triangles_ = mesh.triangles;
  triangle_material_ = mesh.triangle_material;
  triangle_instance_.assign(mesh.triangle_instance.begin(), mesh.triangle_instance.end());
  take_materials(scene);
  measure_triangles();
}

void Surfaces::take_materials(const Scene& scene) {
  for (std::size_t i = textures_.size(); i < scene.textures.size(); ++i) {
    textures_.push_back(std::make_shared<const Texture>(scene.textures[i]));
  }
  for (std::size_t i = materials_.size(); i < scene.materials.size(); ++i) {
    const Look& look = scene.materials[i].look;
    SurfaceMaterial m;
    m.base_colour = clamp_colour(float3(look.base_colour), 1.0F);
    m.emission = float3(look.emission);
    m.texture = look.texture;
    m.roughness = std::clamp(look.roughness, 0.0F, 1.0F);
    m.metallic = std::clamp(look.metallic, 0.0F, 1.0F);
    m.opacity = std::clamp(look.opacity, 0.0F, 1.0F);
    const Rgb mean = m.texture == Look::kNoTexture
                         ? Rgb{1.0F, 1.0F, 1.0F}
                         : textures_[static_cast<std::size_t>(m.texture)]->mean();
    m.mean_base = m.base_colour * mean;
    m.mean_emission = m.emission * mean;
    // Patches have no direction, so that light reflected by metals is passed on as diffuse.
    m.reflectance = clamp_colour(m.mean_base, kLargestReflectance);
    materials_.push_back(m);
  }
}

void Surfaces::measure_triangles() {
  for (auto i = static_cast<std::uint32_t>(area_m2_.size()); i < triangles(); ++i) {
    const Float3 scaled = cross(corner(i, 1) - corner(i, 0), corner(i, 2) - corner(i, 0));
    const float twice_area = norm(scaled);
    // A sliver whose area is lost in single precision may face anywhere.
    face_normals_.push_back(twice_area > 0.0F ? scaled * (1.0F / twice_area)
                                              : Float3{0.0F, 0.0F, 1.0F});
    area_m2_.push_back(0.5F * twice_area);
    float density = 0.0F;
    const int texture = material(i).texture;
    if (texture != Look::kNoTexture && !uvs_.empty() && twice_area > 0.0F) {
      const auto& [a, b, c] = triangles_[i];
      const float uv_area = std::abs((uvs_[b][0] - uvs_[a][0]) * (uvs_[c][1] - uvs_[a][1]) -
                                     (uvs_[c][0] - uvs_[a][0]) * (uvs_[b][1] - uvs_[a][1]));
      const Texture& picture = *textures_[static_cast<std::size_t>(texture)];
      const float texels =
          static_cast<float>(picture.width()) * static_cast<float>(picture.height());
      density = std::sqrt(uv_area * texels / twice_area);
    }
    texels_per_m_.push_back(density);
  }
}

Float3 Surfaces::position(std::uint32_t triangle, float u, float v) const {
  const auto& [a, b, c] = triangles_[triangle];
  return positions_[a] * (1.0F - u - v) + positions_[b] * u + positions_[c] * v;
}

SurfacePoint Surfaces::point(std::uint32_t triangle, float u, float v,
                             const Float3& towards) const {
  SurfacePoint point;
  point.triangle = triangle;
  point.u = u;
  point.v = v;
  point.position = position(triangle, u, v);
  const Float3 face = face_normals_[triangle];
  point.front = dot(face, towards) >= 0.0F;
  point.face_normal = point.front ? face : -face;
  point.normal = point.face_normal;
  if (normals_.empty()) return point;

  const auto& [a, b, c] = triangles_[triangle];
  const Float3 smooth = normals_[a] * (1.0F - u - v) + normals_[b] * u + normals_[c] * v;
  const float length = norm(smooth);
  if (!(length > 1e-6F) || !std::isfinite(length)) return point;
  const Float3 unit = smooth * (1.0F / length);
  // Files disagree about the sides of normals and faces: the normal is turned to the visible side.
  const float side = dot(unit, point.face_normal);
  if (std::abs(side) > 0.1F) point.normal = side > 0.0F ? unit : -unit;
  return point;
}

Rgb Surfaces::texture_colour(const SurfacePoint& point, float width_m) const {
  const int texture = material(point.triangle).texture;
  if (texture == Look::kNoTexture || uvs_.empty()) return {1.0F, 1.0F, 1.0F};
  const auto& [a, b, c] = triangles_[point.triangle];
  const float w = 1.0F - point.u - point.v;
  const float u = uvs_[a][0] * w + uvs_[b][0] * point.u + uvs_[c][0] * point.v;
  const float v = uvs_[a][1] * w + uvs_[b][1] * point.u + uvs_[c][1] * point.v;
  return textures_[static_cast<std::size_t>(texture)]->sample(
      u, v, width_m * texels_per_m_[point.triangle]);
}

}  // namespace earpoint

#pragma once

#include "float3.h"
#include "texture.h"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <earpoint/scene/scene.h>

namespace earpoint {

/// A look, ready for shading.
struct SurfaceMaterial {
  Rgb base_colour{};
  Rgb emission{};
  int texture = Look::kNoTexture;
  float roughness = 0.8F;
  float metallic = 0.0F;
  float opacity = 1.0F;
  Rgb mean_base{};      ///< base colour times the mean of the texture
  Rgb mean_emission{};  ///< emission times the mean of the texture
  Rgb reflectance{};    ///< share of light that is passed on diffusely, averaged over the texture
};

/// A place on a surface, seen from one side.
struct SurfacePoint {
  Float3 position;
  Float3 face_normal;  ///< of the triangle, unit length, on the seen side
  Float3 normal;       ///< interpolated for shading, unit length, on the seen side
  std::uint32_t triangle = 0;
  float u = 0.0F;     ///< weight of the second vertex
  float v = 0.0F;     ///< weight of the third vertex
  bool front = true;  ///< seen from where the vertices turn counter-clockwise
};

/// The triangles of a scene as shading needs them: in single precision, with their materials and
/// textures.
class Surfaces {
 public:
  /// @param scene  as check_scene leaves it
  explicit Surfaces(const Scene& scene);

  /// Those of a scene that begins with the scene of `base`.
  Surfaces(const Surfaces& base, const Scene& scene);

  [[nodiscard]] std::uint32_t triangles() const {
    return static_cast<std::uint32_t>(triangles_.size());
  }
  [[nodiscard]] const std::vector<Float3>& positions() const { return positions_; }
  [[nodiscard]] const std::array<std::uint32_t, 3>& corners(std::uint32_t triangle) const {
    return triangles_[triangle];
  }
  [[nodiscard]] Float3 corner(std::uint32_t triangle, int number) const {
    return positions_[triangles_[triangle][number]];
  }
  [[nodiscard]] const SurfaceMaterial& material(std::uint32_t triangle) const {
    return materials_[triangle_material_[triangle]];
  }
  [[nodiscard]] std::uint32_t material_index(std::uint32_t triangle) const {
    return triangle_material_[triangle];
  }
  [[nodiscard]] const std::vector<SurfaceMaterial>& materials() const { return materials_; }
  [[nodiscard]] std::int32_t instance(std::uint32_t triangle) const {
    return triangle_instance_[triangle];
  }
  [[nodiscard]] float area_m2(std::uint32_t triangle) const { return area_m2_[triangle]; }
  [[nodiscard]] Float3 face_normal(std::uint32_t triangle) const { return face_normals_[triangle]; }

  [[nodiscard]] Float3 position(std::uint32_t triangle, float u, float v) const;

  /// @param towards  a direction to the seen side
  [[nodiscard]] SurfacePoint point(std::uint32_t triangle, float u, float v,
                                   const Float3& towards) const;

  /// The texture's linear colour, white where there is none.
  /// @param width_m  how wide a spot to look at
  [[nodiscard]] Rgb texture_colour(const SurfacePoint& point, float width_m) const;

  /// Where a ray from this point has to start so that it does not meet its own surface.
  /// @param side  the face normal of the side to leave to
  [[nodiscard]] Float3 ray_start(const Float3& position, const Float3& side) const {
    return position + side * start_offset_m_;
  }

 private:
  void append(const Scene& scene);
  void take_materials(const Scene& scene);
  void measure_triangles();

  std::vector<Float3> positions_;
  std::vector<Float3> normals_;            // [vertices], or empty
  std::vector<std::array<float, 2>> uvs_;  // [vertices], or empty
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<std::uint32_t> triangle_material_;
  std::vector<std::int32_t> triangle_instance_;
  std::vector<Float3> face_normals_;  // [triangles]
  std::vector<float> area_m2_;        // [triangles]
  std::vector<float> texels_per_m_;   // [triangles]
  std::vector<SurfaceMaterial> materials_;
  std::vector<std::shared_ptr<const Texture>> textures_;
  float start_offset_m_ = 1e-4F;
};

}  // namespace earpoint

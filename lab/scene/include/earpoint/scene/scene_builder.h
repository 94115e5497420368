#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <earpoint/scene/scene.h>

namespace earpoint {

/// Where a thing stands: turned about z, scaled, then moved.
struct Placement {
  Vector3 position_m;            ///< of the thing's origin, the middle of its base
  double yaw_rad = 0.0;          ///< turns its front (x) counter-clockwise
  Vector3 scale{1.0, 1.0, 1.0};  ///< along its own axes, before it turns
};

/// @return a point of the thing in the world
Vector3 placed(const Placement& placement, const Vector3& point);

/// A material of a scene under construction, and the size of its texture.
struct Surface {
  std::uint32_t material = 0;
  double tile_m = 1.0;  ///< what the texture spans before it repeats
};

/// Four corners, counter-clockwise as seen from the side that the face looks to.
using Quad = std::array<Vector3, 4>;

/// Puts a scene together, one instance after the other.
class SceneBuilder {
 public:
  /// The same key gives the same surface: `material` is stored at its first use only.
  Surface add_surface(const std::string& key, const Material& material, double tile_m = 1.0);

  /// @return whether a surface with that key is there already; if so, sets `surface`
  bool find_surface(const std::string& key, Surface& surface) const;

  /// @return the texture's index, for Look::texture
  int add_texture(Image image);

  /// What is added from here on belongs to a new instance and is placed by `placement`.
  /// @return its index
  std::uint32_t begin_instance(const std::string& name, InstanceKind kind,
                               const Placement& placement = {});

  /// A flat face, textured by where it lies: one texture per `tile_m`, upright on walls.
  void add_quad(const Quad& corners, Surface surface);

  /// A flat face with given texture coordinates.
  void add_quad(const Quad& corners, Surface surface,
                const std::array<std::array<float, 2>, 4>& uvs);

  /// A closed box, faces outward.
  void add_box(const Vector3& low, const Vector3& high, Surface surface);

  /// An upright closed prism with `sides` sides that narrows or widens from bottom to top, smooth
  /// around. A radius of 0 makes a point.
  void add_cylinder(const Vector3& base, double bottom_radius_m, double top_radius_m,
                    double height_m, int sides, Surface surface);

  /// A closed smooth ellipsoid.
  /// @param sides  around its equator, at least 4; half as many from pole to pole
  void add_ellipsoid(const Vector3& centre, const Vector3& radii_m, int sides, Surface surface);

  /// Triangles with their own normals and texture coordinates, all arrays as in Mesh.
  /// @param surfaces  one per value of `mesh.triangle_material`
  void add_mesh(const Mesh& mesh, const std::vector<Surface>& surfaces);

  void add_lamp(const Lamp& lamp) { scene_.lamps.push_back(lamp); }

  [[nodiscard]] const Scene& scene() const { return scene_; }
  /// @return the scene, without materials and textures that no face uses; the builder is spent
  [[nodiscard]] Scene take();

 private:
  std::uint32_t add_vertex(const Vector3& point, const Vector3& normal,
                           const std::array<float, 2>& uv);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, Surface surface);

  Scene scene_;
  std::map<std::string, Surface> surfaces_;
  Placement placement_;
};

}  // namespace earpoint

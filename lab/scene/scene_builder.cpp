#include <earpoint/scene/scene_builder.h>

#include <cmath>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

Vector3 turned(double yaw_rad, const Vector3& v) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  return {c * v.x - s * v.y, s * v.x + c * v.y, v.z};
}

std::array<float, 3> to_floats(const Vector3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Texture coordinates by position: seen from the front, u grows to the right and v upwards.
std::array<float, 2> planar_uv(const Vector3& point, const Vector3& normal, double tile_m) {
  double u = point.x;
  double v = point.y;
  if (std::abs(normal.z) < 0.7) {
    const Vector3 right = normalized(cross({0, 0, 1}, normal));
    u = dot(point, right);
    v = point.z;
  }
  return {static_cast<float>(u / tile_m), static_cast<float>(v / tile_m)};
}

/// Keeps the entries that are used, in their order.
/// @return for every old index the new one
template <typename T>
std::vector<std::uint32_t> keep_used(std::vector<T>& items, const std::vector<char>& used) {
  std::vector<std::uint32_t> moved(items.size(), 0);
  std::vector<T> kept;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (used[i] == 0) continue;
    moved[i] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(std::move(items[i]));
  }
  items = std::move(kept);
  return moved;
}

}  // namespace

Vector3 placed(const Placement& placement, const Vector3& point) {
  const Vector3 scaled{point.x * placement.scale.x, point.y * placement.scale.y,
                       point.z * placement.scale.z};
  return turned(placement.yaw_rad, scaled) + placement.position_m;
}

Surface SceneBuilder::add_surface(const std::string& key, const Material& material, double tile_m) {
  Surface surface;
  if (find_surface(key, surface)) return surface;
  EARPOINT_CHECK(tile_m > 0.0);
  surface = {.material = static_cast<std::uint32_t>(scene_.materials.size()), .tile_m = tile_m};
  scene_.materials.push_back(material);
  surfaces_.emplace(key, surface);
  return surface;
}

bool SceneBuilder::find_surface(const std::string& key, Surface& surface) const {
  const auto found = surfaces_.find(key);
  if (found == surfaces_.end()) return false;
  surface = found->second;
  return true;
}

int SceneBuilder::add_texture(Image image) {
  scene_.textures.push_back(std::move(image));
  return static_cast<int>(scene_.textures.size()) - 1;
}

std::uint32_t SceneBuilder::begin_instance(const std::string& name, InstanceKind kind,
                                           const Placement& placement) {
  placement_ = placement;
  scene_.instances.push_back({.name = name, .kind = kind});
  return static_cast<std::uint32_t>(scene_.instances.size() - 1);
}

std::uint32_t SceneBuilder::add_vertex(const Vector3& point, const Vector3& normal,
                                       const std::array<float, 2>& uv) {
  const Vector3 unscaled{normal.x / placement_.scale.x, normal.y / placement_.scale.y,
                         normal.z / placement_.scale.z};
  scene_.mesh.positions.push_back(to_floats(placed(placement_, point)));
  scene_.mesh.normals.push_back(to_floats(turned(placement_.yaw_rad, normalized(unscaled))));
  scene_.mesh.uvs.push_back(uv);
  return static_cast<std::uint32_t>(scene_.mesh.positions.size() - 1);
}

void SceneBuilder::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                Surface surface) {
  EARPOINT_CHECK(!scene_.instances.empty());
  scene_.mesh.triangles.push_back({a, b, c});
  scene_.mesh.triangle_material.push_back(surface.material);
  scene_.mesh.triangle_instance.push_back(static_cast<std::uint32_t>(scene_.instances.size() - 1));
}

void SceneBuilder::add_quad(const Quad& corners, Surface surface) {
  const Vector3 normal = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
  std::array<std::array<float, 2>, 4> uvs{};
  for (std::size_t i = 0; i < 4; ++i) uvs[i] = planar_uv(corners[i], normal, surface.tile_m);
  add_quad(corners, surface, uvs);
}

void SceneBuilder::add_quad(const Quad& corners, Surface surface,
                            const std::array<std::array<float, 2>, 4>& uvs) {
  const Vector3 normal = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
  std::array<std::uint32_t, 4> v{};
  for (std::size_t i = 0; i < 4; ++i) v[i] = add_vertex(corners[i], normal, uvs[i]);
  add_triangle(v[0], v[1], v[2], surface);
  add_triangle(v[0], v[2], v[3], surface);
}

void SceneBuilder::add_box(const Vector3& low, const Vector3& high, Surface surface) {
  const auto corner = [&](int bits) {
    return Vector3{(bits & 1) != 0 ? high.x : low.x, (bits & 2) != 0 ? high.y : low.y,
                   (bits & 4) != 0 ? high.z : low.z};
  };
  constexpr std::array<std::array<int, 4>, 6> kLoops = {
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& [a, b, c, d] : kLoops) {
    add_quad({corner(a), corner(b), corner(c), corner(d)}, surface);
  }
}

void SceneBuilder::add_cylinder(const Vector3& base, double bottom_radius_m, double top_radius_m,
                                double height_m, int sides, Surface surface) {
  EARPOINT_CHECK(sides >= 3 && height_m > 0.0);
  const auto rim = [&](int i, double radius_m, double z) {
    const double angle_rad = 2.0 * kPi * (i % sides) / sides;
    return base + Vector3{radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad), z};
  };
  const double slope = (bottom_radius_m - top_radius_m) / height_m;
  const double around_m = 2.0 * kPi * std::max(bottom_radius_m, top_radius_m);
  const auto side_vertex = [&](int i, double radius_m, double z) {
    const double angle_rad = 2.0 * kPi * i / sides;
    return add_vertex(rim(i, radius_m, z), {std::cos(angle_rad), std::sin(angle_rad), slope},
                      {static_cast<float>(around_m * i / sides / surface.tile_m),
                       static_cast<float>(z / surface.tile_m)});
  };
  for (int i = 0; i < sides; ++i) {
    const std::uint32_t a = side_vertex(i, bottom_radius_m, 0.0);
    const std::uint32_t b = side_vertex(i + 1, bottom_radius_m, 0.0);
    const std::uint32_t c = side_vertex(i + 1, top_radius_m, height_m);
    const std::uint32_t d = side_vertex(i, top_radius_m, height_m);
    if (bottom_radius_m > 0.0) add_triangle(a, b, c, surface);
    if (top_radius_m > 0.0) add_triangle(a, c, d, surface);
  }
  const auto cap = [&](double radius_m, double z, double up) {
    if (radius_m <= 0.0) return;
    const Vector3 normal{0, 0, up};
    const auto flat = [&](const Vector3& point) {
      return add_vertex(point, normal, planar_uv(point, normal, surface.tile_m));
    };
    for (int i = 1; i + 1 < sides; ++i) {
      const std::uint32_t a = flat(rim(0, radius_m, z));
      const std::uint32_t b = flat(rim(up > 0.0 ? i : i + 1, radius_m, z));
      const std::uint32_t c = flat(rim(up > 0.0 ? i + 1 : i, radius_m, z));
      add_triangle(a, b, c, surface);
    }
  };
  cap(bottom_radius_m, 0.0, -1.0);
  cap(top_radius_m, height_m, 1.0);
}

void SceneBuilder::add_ellipsoid(const Vector3& centre, const Vector3& radii_m, int sides,
                                 Surface surface) {
  EARPOINT_CHECK(sides >= 4);
  const int rings = sides / 2;
  std::vector<std::uint32_t> grid;
  for (int j = 0; j <= rings; ++j) {
    const double polar_rad = kPi * j / rings;
    for (int i = 0; i <= sides; ++i) {
      const double azimuth_rad = 2.0 * kPi * (i % sides) / sides;
      // Each pole is a single point, regardless of the rounding of sin(pi).
      const double r = j == 0 || j == rings ? 0.0 : std::sin(polar_rad);
      const Vector3 unit{r * std::cos(azimuth_rad), r * std::sin(azimuth_rad), std::cos(polar_rad)};
      const Vector3 point{centre.x + radii_m.x * unit.x, centre.y + radii_m.y * unit.y,
                          centre.z + radii_m.z * unit.z};
      const Vector3 normal{unit.x / radii_m.x, unit.y / radii_m.y, unit.z / radii_m.z};
      grid.push_back(add_vertex(point, normal,
                                {static_cast<float>(i) / static_cast<float>(sides),
                                 1.0F - static_cast<float>(j) / static_cast<float>(rings)}));
    }
  }
  const auto at = [&](std::ptrdiff_t i, std::ptrdiff_t j) { return grid[j * (sides + 1) + i]; };
  for (int j = 0; j < rings; ++j) {
    for (int i = 0; i < sides; ++i) {
      if (j + 1 < rings) add_triangle(at(i, j), at(i, j + 1), at(i + 1, j + 1), surface);
      if (j > 0) add_triangle(at(i, j), at(i + 1, j + 1), at(i + 1, j), surface);
    }
  }
}

void SceneBuilder::add_mesh(const Mesh& mesh, const std::vector<Surface>& surfaces) {
  EARPOINT_CHECK(mesh.normals.size() == mesh.positions.size());
  const auto first = static_cast<std::uint32_t>(scene_.mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto& n = mesh.normals[i];
    const Vector3 normal{n[0], n[1], n[2]};
    add_vertex(vertex(mesh, static_cast<std::uint32_t>(i)),
               norm(normal) > 0.0 ? normal : Vector3{0, 0, 1},
               mesh.uvs.empty() ? std::array<float, 2>{} : mesh.uvs[i]);
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    add_triangle(first + a, first + b, first + c, surfaces[mesh.triangle_material[i]]);
  }
}

Scene SceneBuilder::take() {
  std::vector<char> used(scene_.materials.size(), 0);
  for (const std::uint32_t material : scene_.mesh.triangle_material) used[material] = 1;
  const std::vector<std::uint32_t> moved = keep_used(scene_.materials, used);
  for (std::uint32_t& material : scene_.mesh.triangle_material) material = moved[material];

  std::vector<char> shown(scene_.textures.size(), 0);
  for (const Material& material : scene_.materials) {
    if (material.look.texture != Look::kNoTexture) {
      shown[static_cast<std::size_t>(material.look.texture)] = 1;
    }
  }
  const std::vector<std::uint32_t> hung = keep_used(scene_.textures, shown);
  for (Material& material : scene_.materials) {
    int& texture = material.look.texture;
    if (texture != Look::kNoTexture) {
      texture = static_cast<int>(hung[static_cast<std::size_t>(texture)]);
    }
  }
  surfaces_.clear();
  return std::move(scene_);
}

}  // namespace earpoint

#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/scene/material.h>
#include <earpoint/scene/mesh.h>

namespace earpoint {

enum class InstanceKind { structure, furniture, person };

/// One thing of a scene: its triangles carry its index.
struct Instance {
  std::string name;
  InstanceKind kind = InstanceKind::structure;
};

/// A small lamp. Surfaces with `Look::emission` shine too.
struct Lamp {
  Vector3 position_m;
  std::array<float, 3> intensity{};  ///< radiant intensity, linear red, green, blue
  float radius_m = 0.05F;            ///< of the shining ball: softens shadows
};

/// What can be heard and seen. z up, metres; the floor of a procedural scene lies at z = 0.
struct Scene {
  Mesh mesh;
  std::vector<Material> materials;
  std::vector<Instance> instances;
  std::vector<Image> textures;  ///< RGB, sRGB; see `Look::texture`
  std::vector<Lamp> lamps;
};

/// What `check_scene` corrected.
struct SceneCheck {
  std::size_t zero_area_triangles = 0;  ///< dropped
};

/// Makes sure that a scene can be traced; drops triangles without an area.
/// @param where  what errors call the scene, e.g. its file
/// @throws InputError if there are no faces, a position is not a number or further than 10 km
///         from another along an axis, an index of a vertex, material, instance or texture points
///         nowhere, an array has the wrong length, or a material's number is outside [0, 1]
SceneCheck check_scene(Scene& scene, std::string_view where);

/// A closed empty box with a corner at the origin: the faces x low, x high, y low, y high, z low
/// (floor), z high (ceiling), two triangles each, normals inward.
/// @param lengths_m   along x, y, z; > 0
/// @param absorption  of all faces, per band
/// @param scattering  of all faces, per band
Scene make_shoebox(const Vector3& lengths_m, const BandArray& absorption,
                   const BandArray& scattering);

/// The same with a material per face, in the order above.
Scene make_shoebox(const Vector3& lengths_m, const std::array<AcousticMaterial, 6>& faces);

}  // namespace earpoint

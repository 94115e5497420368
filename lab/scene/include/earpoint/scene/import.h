#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/scene/closure.h>
#include <earpoint/scene/material_table.h>
#include <earpoint/scene/scene.h>

namespace earpoint {

/// Which axis of a file points up.
enum class UpAxis {
  y,  ///< file z becomes front, x left, y up: glTF's own front is our front
  z,  ///< taken as it is
};

struct ImportOptions {
  std::optional<UpAxis> up_axis{};  ///< default: y for glTF, GLB and OBJ, z for PLY
  double unit_m = 1.0;              ///< the length of the file's unit; 0.01 for centimetres
  const MaterialTable* materials = nullptr;  ///< null: standard_materials()
  bool close_ceiling = false;                ///< see closure.h
};

/// What an importer had to decide or leave out.
struct ImportReport {
  std::size_t zero_area_triangles = 0;        ///< dropped
  std::size_t points_and_lines = 0;           ///< not faces: dropped
  std::vector<std::string> missing_textures;  ///< as the file names them: plain colour instead
  std::map<std::string, std::string> sounds;  ///< surface name -> acoustic material
  std::map<std::string, std::size_t> unknown_surfaces;  ///< no pattern matched: name -> faces
  double added_ceiling_m2 = 0.0;
  double coordinate_step_m = 0.0;  ///< of single precision, at the file's largest coordinate
  Vector3 size_m;                  ///< along each axis
  Closure closure;                 ///< of the scene as returned

  /// @return warnings, a line each, with a hint
  [[nodiscard]] std::vector<std::string> warnings() const;
};

struct ImportedScene {
  Scene scene;
  /// Where the scene's origin lies in the file's coordinates (metres, our axes). Zero but for
  /// models far from their origin, more than 1 km, as in a land survey's coordinates: those are
  /// moved.
  Vector3 origin_m;
  ImportReport report;
};

/// Reads glTF 2.0 (.gltf, .glb), Wavefront (.obj with .mtl) or Stanford (.ply) models: transforms
/// of nodes applied, polygons cut into triangles, embedded and external textures (PNG, JPEG) read,
/// colours of vertices kept where there is no texture.
///
/// A surface sounds as the table says for its material's name; if no pattern matches that, for the
/// name of its mesh or node; else as the table's default.
/// Coordinates kept as small integers (KHR_mesh_quantization) are read from .glb, meshopt's
/// compression is not.
/// @throws InputError if the file is missing, of another format, damaged, has no faces, is smaller
///         than 0.5 m or larger than 1 km, or is not a scene as check_scene wants it
ImportedScene import_scene(const std::filesystem::path& path, const ImportOptions& options = {});

}  // namespace earpoint

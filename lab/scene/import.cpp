#include <earpoint/scene/import.h>

#include "model_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/core.h>
#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kLargest_m = 1000.0;  // no room is larger; sound decays before it crosses it
// Heights of storeys, halls and houses; other heights suggest a wrong unit.
constexpr double kUsualHeight_m[] = {1.5, 30.0};
constexpr double kCoarse_m = 1e-3;  ///< of coordinates: coarser than details of models
constexpr double kLeaky = 0.01;     ///< share of escaping rays above which reverberation is wrong

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

UpAxis default_up_axis(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".ply") return UpAxis::z;
  if (extension == ".glb" || extension == ".gltf" || extension == ".obj") return UpAxis::y;
  throw InputError(path.string(),
                   fmt::format("expected a .glb, .gltf, .obj or .ply model, found '{}'", extension),
                   "convert it to .glb");
}

double largest_coordinate_m(const Bounds& box) {
  return std::max({-box.low.x, -box.low.y, -box.low.z, box.high.x, box.high.y, box.high.z});
}

/// Moves a scene that is far from the origin close to it, as rays are traced in single precision.
void move_to_origin(ImportedScene& imported) {
  const Bounds box = bounds(imported.scene.mesh);
  const auto largest_m = static_cast<float>(largest_coordinate_m(box));
  imported.report.coordinate_step_m =
      std::nextafter(largest_m, std::numeric_limits<float>::infinity()) - largest_m;
  constexpr float kFar_m = 1000.0F;
  if (!(largest_m > kFar_m)) return;
  imported.origin_m = {std::floor(box.low.x), std::floor(box.low.y), std::floor(box.low.z)};
  for (auto& position : imported.scene.mesh.positions) {
    position = {static_cast<float>(position[0] - imported.origin_m.x),
                static_cast<float>(position[1] - imported.origin_m.y),
                static_cast<float>(position[2] - imported.origin_m.z)};
  }
}

/// @return the extent along each axis
Vector3 check_size(const Scene& scene, const std::filesystem::path& path) {
  const Bounds box = bounds(scene.mesh);
  const Vector3 extent = box.high - box.low;
  const double largest_m = std::max({extent.x, extent.y, extent.z});
  if (largest_m < 0.5) {
    throw InputError(path.string(), fmt::format("is only {:.3g} m in size", largest_m),
                     "give the length of its unit in metres: 1000 if it is in kilometres");
  }
  if (largest_m > kLargest_m) {
    throw InputError(
        path.string(),
        fmt::format("is {:.6g} m in size, expected at most {:g} m", largest_m, kLargest_m),
        "give the length of its unit in metres: 0.01 if it is in centimetres");
  }
  return extent;
}

}  // namespace

std::vector<std::string> ImportReport::warnings() const {
  std::vector<std::string> lines;
  if (zero_area_triangles > 0) {
    lines.push_back(fmt::format("dropped {} faces without an area", zero_area_triangles));
  }
  if (points_and_lines > 0) {
    lines.push_back(fmt::format("left out {} points and lines", points_and_lines));
  }
  if (!missing_textures.empty()) {
    lines.push_back(
        fmt::format("{} textures are missing or not PNG or JPEG, e.g. '{}'; put them "
                    "beside the model",
                    missing_textures.size(), missing_textures.front()));
  }
  for (const auto& [name, faces] : unknown_surfaces) {
    lines.push_back(
        fmt::format("surface '{}' ({} faces) matches no pattern and gets the material {}; "
                    "name it in the materials",
                    name, faces, sounds.at(name)));
  }
  if (coordinate_step_m > kCoarse_m) {
    lines.push_back(
        fmt::format("coordinates are so large that their precision is only {:.2g} m; move the "
                    "model to the origin before exporting it",
                    coordinate_step_m));
  }
  if (size_m.z < kUsualHeight_m[0] || size_m.z > kUsualHeight_m[1]) {
    lines.push_back(fmt::format(
        "the model is {:.4g} m high; check the length of its unit and which axis points up",
        size_m.z));
  }
  if (closure.rays == 0) {
    lines.push_back("no position has a floor and walls around it; is this a room?");
  } else if (closure.escaping_share > kLeaky) {
    const bool upwards = closure.escaping_up_share > 0.5 * closure.escaping_share;
    lines.push_back(fmt::format(
        "{:.1f} % of rays escape through holes ({} open edges, {:.1f} m); {}",
        100.0 * closure.escaping_share, closure.open_edges, closure.open_edges_m,
        upwards ? "most go up: close the ceiling" : "close the walls in a modelling program"));
  }
  return lines;
}

ImportedScene import_scene(const std::filesystem::path& path, const ImportOptions& options) {
  if (!(options.unit_m > 0.0) || !std::isfinite(options.unit_m)) {
    throw InputError("unit", fmt::format("expected a length above 0 m, found {}", options.unit_m));
  }
  const UpAxis up_axis = options.up_axis.value_or(default_up_axis(path));
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw InputError(path.string(), "does not exist, or is not a file");
  }
  ImportedScene imported = lower_extension(path) == ".ply"
                               ? read_ply_scene(path, options, up_axis)
                               : read_with_assimp(path, options, up_axis);
  move_to_origin(imported);
  imported.report.zero_area_triangles =
      check_scene(imported.scene, path.string()).zero_area_triangles;
  imported.report.size_m = check_size(imported.scene, path);
  if (options.close_ceiling) {
    const MaterialTable& table =
        options.materials != nullptr ? *options.materials : standard_materials();
    Material lid{.acoustic = *table.match("ceiling").material, .look = {}};
    lid.look.base_colour = {0.85F, 0.85F, 0.85F};
    imported.report.added_ceiling_m2 = close_ceiling(imported.scene, lid);
  }
  imported.report.closure = check_closure(imported.scene);
  return imported;
}

}  // namespace earpoint

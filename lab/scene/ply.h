#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace earpoint {

/// What a PLY file holds, as it is there.
struct PlyModel {
  std::vector<std::array<float, 3>> positions;       ///< [vertices]
  std::vector<std::array<float, 3>> normals;         ///< [vertices], or empty
  std::vector<std::array<float, 2>> uvs;             ///< [vertices], or empty; v points up
  std::vector<std::array<float, 3>> colours;         ///< [vertices], in [0, 1], or empty
  std::vector<std::vector<std::uint32_t>> polygons;  ///< at least 3 corners each
  std::size_t small_faces = 0;                       ///< with fewer corners: left out
};

/// Reads a Stanford polygon file: ascii, or binary of either byte order.
/// @throws InputError if it is missing, not PLY, cut short, or a face has a vertex that is not
///         there
PlyModel read_ply(const std::filesystem::path& path);

}  // namespace earpoint

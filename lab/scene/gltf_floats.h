#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace earpoint {

/// Vertex positions, normals, tangents and texture coordinates of a binary glTF file that are kept
/// as small integers (KHR_mesh_quantization) become floats, which Assimp reads.
/// @param json  of the file
/// @return  the file with floats; nothing if it has floats already
/// @throws InputError if an accessor points outside of its data, is sparse or has a kind that glTF
///         does not allow there; if the file is not a binary one; if it needs meshopt's decoder
std::optional<std::vector<std::byte>> gltf_with_floats(const std::filesystem::path& path,
                                                       nlohmann::json json);

}  // namespace earpoint

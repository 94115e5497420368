#pragma once

#include <array>
#include <filesystem>
#include <string>

#include <earpoint/scene/import.h>

namespace earpoint {

/// A glTF or OBJ file, in our frame and metres, not yet checked. Instances are its nodes; materials
/// carry looks, and sounds as import_scene describes.
ImportedScene read_with_assimp(const std::filesystem::path& path, const ImportOptions& options,
                               UpAxis up_axis);

/// A PLY file, likewise. Its one surface is called like the file.
ImportedScene read_ply_scene(const std::filesystem::path& path, const ImportOptions& options,
                             UpAxis up_axis);

/// @return a file's vector in our frame
std::array<float, 3> to_our_frame(const std::array<double, 3>& v, UpAxis up_axis, double scale);

/// Gives vertices whose normal is missing or broken that of a face, and all the length 1.
void mend_normals(Mesh& mesh);

/// @return `text` with every control character turned into a space
std::string one_line(std::string text);

}  // namespace earpoint

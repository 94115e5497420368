#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <earpoint/scene/model_pack.h>

namespace earpoint {

/// What conversion made, and what it could not use.
struct SweetHomeResult {
  ModelPack pack;
  std::vector<std::string> left_out;  ///< one line for each model, with the reason
};

/// Converts models of Sweet Home 3D's furniture libraries (Debian's sweethome3d-furniture).
///
/// A library is an unpacked .sh3f file: a folder with PluginFurnitureCatalog.properties, whose
/// width, depth and height in centimetres give each model its size (raw units differ), and
/// modelRotation its posture. Models with many triangles are simplified, textures shrunk.
/// @param libraries  a folder with the unpacked libraries by name, e.g. Scopia/
/// @param list       JSON: which models to take as what (sweet_home.json)
/// @throws InputError if the list or a catalogue is missing or damaged; a model that is broken is
///         left out
SweetHomeResult convert_sweet_home(const std::filesystem::path& libraries,
                                   const std::filesystem::path& list);

}  // namespace earpoint

#pragma once

#include <filesystem>

#include <earpoint/scene/scene.h>

namespace earpoint {

/// Writes a scene as one binary glTF 2.0 file that any viewer opens: a mesh per instance, looks as
/// glTF materials named "acoustic name" (so that import_scene gives the sound back), textures as
/// PNG inside, y up. Lamps are left out.
/// @throws InputError if the file cannot be written
void write_glb(const Scene& scene, const std::filesystem::path& path);

}  // namespace earpoint

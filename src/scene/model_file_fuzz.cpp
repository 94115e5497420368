#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <unistd.h>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/scene/import.h>

/// The first byte chooses the format: OBJ, PLY, GLB or glTF. Any bytes are refused with InputError,
/// or become a scene that passes its own check.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  if (size == 0) return 0;
  const char* extension = data[0] == 'o'   ? ".obj"
                          : data[0] == 'p' ? ".ply"
                          : data[0] == 'b' ? ".glb"
                                           : ".gltf";
  static const std::string stem =
      (std::filesystem::temp_directory_path() / ("earpoint_fuzz_" + std::to_string(::getpid())))
          .string();
  const std::string path = stem + extension;
  write_file(path, std::string_view(reinterpret_cast<const char*>(data) + 1, size - 1));
  try {
    ImportedScene imported = import_scene(path);
    if (check_scene(imported.scene, "again").zero_area_triangles > 0) std::abort();
  } catch (const InputError&) {
  }
  std::filesystem::remove(path);
  return 0;
}

#include "model_reader.h"

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <fuzz_file.h>
#include <unistd.h>

#include <earpoint/error.h>
#include <earpoint/scene/import.h>

namespace {

/// A file in memory under a name with the extension that readers need.
class NamedFile {
 public:
  NamedFile(const FuzzFile& file, const char* extension)
      : path_(std::filesystem::temp_directory_path() /
              ("earpoint_fuzz_" + std::to_string(::getpid()) + extension)) {
    std::filesystem::remove(path_);
    std::filesystem::create_symlink(file.path(), path_);
  }
  ~NamedFile() { std::filesystem::remove(path_); }
  NamedFile(const NamedFile&) = delete;
  NamedFile& operator=(const NamedFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace

/// The first byte chooses the format: OBJ, PLY, GLB or glTF; a capital letter runs the whole
/// import, most of whose time is the search for holes; otherwise only the file reader. Any bytes
/// are refused with InputError, or become a scene that passes its own check.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  if (size == 0) return 0;
  const bool is_whole = data[0] >= 'A' && data[0] <= 'Z';
  const int format = data[0] | 0x20;
  const char* extension = format == 'o'   ? ".obj"
                          : format == 'p' ? ".ply"
                          : format == 'b' ? ".glb"
                                          : ".gltf";
  const FuzzFile bytes(data + 1, size - 1);
  const NamedFile file(bytes, extension);
  try {
    ImportedScene imported = is_whole        ? import_scene(file.path())
                             : format == 'p' ? read_ply_scene(file.path(), {}, UpAxis::z)
                                             : read_with_assimp(file.path(), {}, UpAxis::y);
    check_scene(imported.scene, "input");
    if (check_scene(imported.scene, "again").zero_area_triangles > 0) std::abort();
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}

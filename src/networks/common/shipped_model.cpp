#include <earpoint/network/shipped_model.h>

#include <cstdlib>
#include <system_error>

#include <earpoint/core/platform/program_path.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

/// Folders above the program that may hold the models: a build tree is that deep.
constexpr int kMostFolders = 6;

}  // namespace

std::optional<fs::path> shipped_model_path(std::string_view file_name) {
  return shipped_model_path(file_name, program_path());
}

std::optional<fs::path> shipped_model_path(std::string_view file_name, const fs::path& program) {
  for (const fs::path& folder : model_folders(program)) {
    fs::path path = folder / file_name;
    std::error_code error;
    if (fs::is_regular_file(path, error)) return path;
  }
  return std::nullopt;
}

std::vector<fs::path> model_folders(const fs::path& program) {
  if (const char* named = std::getenv("EARPOINT_MODELS_DIR"); named != nullptr && *named != 0) {
    return {named};
  }
  std::vector<fs::path> folders;
  fs::path folder = program.parent_path();
  for (int i = 0; i < kMostFolders && folder.has_relative_path(); ++i) {
    for (const char* below : {"models", "share/earpoint/models"}) folders.push_back(folder / below);
    folder = folder.parent_path();
  }
  folders.emplace_back(EARPOINT_INSTALLED_MODELS);
  return folders;
}

}  // namespace earpoint

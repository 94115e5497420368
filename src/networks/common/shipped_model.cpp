#include <earpoint/network/shipped_model.h>

#include <cstdlib>
#include <system_error>
#include <utility>

#include <earpoint/core/platform/program_path.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

/// Folders above the program that may hold the models: a build tree is that deep.
constexpr int kMostFolders = 6;

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

}  // namespace

std::optional<fs::path> shipped_model_path(std::string_view file_name) {
  return shipped_model_path(file_name, program_path());
}

std::optional<fs::path> shipped_model_path(std::string_view file_name, const fs::path& program) {
  if (const char* folder = std::getenv("EARPOINT_MODELS_DIR"); folder != nullptr && *folder != 0) {
    const fs::path path = fs::path(folder) / file_name;
    return is_file(path) ? std::optional(path) : std::nullopt;
  }
  fs::path folder = program.parent_path();
  for (int i = 0; i < kMostFolders && folder.has_relative_path(); ++i) {
    for (const char* below : {"models", "share/earpoint/models"}) {
      fs::path path = folder / below / file_name;
      if (is_file(path)) return path;
    }
    folder = folder.parent_path();
  }
  fs::path installed = fs::path(EARPOINT_INSTALLED_MODELS) / file_name;
  return is_file(installed) ? std::optional(std::move(installed)) : std::nullopt;
}

}  // namespace earpoint

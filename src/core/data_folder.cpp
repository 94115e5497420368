#include <earpoint/core/data_folder.h>

#include <cstdlib>

namespace earpoint {
namespace {

std::optional<std::filesystem::path> environment_folder(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr || *value == '\0') return std::nullopt;
  return std::filesystem::path(value);
}

}  // namespace

std::optional<std::filesystem::path> data_folder() {
  if (auto own = environment_folder("EARPOINT_DATA_DIR")) return own;
  if (const auto data = environment_folder("XDG_DATA_HOME")) return *data / "earpoint";
  if (const auto home = environment_folder("HOME")) return *home / ".local/share/earpoint";
  return std::nullopt;
}

}  // namespace earpoint

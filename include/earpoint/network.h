#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <earpoint/export.h>

namespace earpoint {

/// Description of a weight file.
struct NetworkInfo {
  std::filesystem::path file;   ///< its path
  std::string kind;             ///< "gtf", "vigas", "vam", "rt60_estimator" or "people"
  std::string description;      ///< the network's shape as JSON
  std::int64_t parameters = 0;  ///< numbers in all of its tensors
  bool renders = false;         ///< Renderer::open() takes it
  bool streams = false;         ///< Renderer::stream() too
};

/// The names of the installed models, sorted, e.g. "enhance", "gtf".
///
/// They are searched in the folder that the environment's EARPOINT_MODELS_DIR names, if it is
/// set; otherwise in models/ and share/earpoint/models/ beside or above the running program; last
/// where the library's build installs them.
[[nodiscard]] EARPOINT_API std::vector<std::string> installed_networks();

/// Reads a weight file without rendering.
/// @param model  the name of an installed model, or a file
/// @throws InputError if there is no such model, or it is not a weight file of a known network
[[nodiscard]] EARPOINT_API NetworkInfo describe_network(const std::string& model);

}  // namespace earpoint

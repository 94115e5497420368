#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace earpoint::plugin {

/// A network that renders live sound.
struct StreamingModel {
  std::string name;            ///< e.g. "gtf"
  std::filesystem::path file;  ///< its weights
};

/// The networks that render live sound: gtf and enhance first, so that their numbers in saved
/// sessions stay, then others by name; at most `kMostModels`.
///
/// If the environment's EARPOINT_MODELS_DIR is set, only the folder that it names counts. Otherwise
/// they are searched in `models` beside the plugin's binary, in `Resources/models` of its bundle,
/// in `share/earpoint/models` of every folder above, and last where the library searches
/// (installed_networks()). Of two with one name the first counts. Files that are no network that
/// streams are left out.
/// @param binary  path of the plugin's shared object
[[nodiscard]] std::vector<StreamingModel> find_streaming_models(
    const std::filesystem::path& binary);

inline constexpr int kMostModels = 16;

}  // namespace earpoint::plugin

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <earpoint/dataset/replay.h>
#include <earpoint/dataset/rwavs.h>
#include <earpoint/dataset/soundspaces.h>

namespace earpoint {

/// The forms that data sets have on disk.
enum class DatasetLayout {
  soundspaces,  ///< SoundSpaces-NVAS v16, or what `earpoint simulate` wrote in its form
  replay,       ///< Replay-NVAS v3
  rwavs,        ///< Real-World Audio-Visual Scenes
};

/// @param name  "soundspaces", "replay" or "rwavs"
/// @throws InputError naming layout if it is none of them
[[nodiscard]] DatasetLayout layout_named(std::string_view name);

/// What a folder holds. A published data set is found from its root, the folder that holds
/// data/synthetic_dataset/v16 or data/appen_dataset/v3, and from every folder on the way there,
/// that one included; one of `earpoint simulate` by its dataset.json; RWAVS from the folder with
/// its position.json, or from a scene.
/// @param asked  the layout to look for; nothing: whichever there is
/// @throws InputError if there is none, not the one that was asked for, or several where none was
///         asked for
[[nodiscard]] DatasetLayout dataset_layout(const std::filesystem::path& folder,
                                           std::optional<DatasetLayout> asked);

/// Where things lie in a folder of the SoundSpaces layout, as dataset_layout() finds it.
/// @throws InputError if it is none, or if its dataset.json is malformed
[[nodiscard]] SoundSpacesDataset::Options soundspaces_options(const std::filesystem::path& folder,
                                                              const std::string& split);

/// Where things lie in a folder of the Replay layout, as dataset_layout() finds it.
/// @throws InputError if it is none
[[nodiscard]] ReplayDataset::Options replay_options(const std::filesystem::path& folder,
                                                    const std::string& split);

/// Where things lie in a folder of RWAVS, as dataset_layout() finds it; of a scene's folder, that
/// scene alone.
/// @throws InputError if it is none
[[nodiscard]] RwavsDataset::Options rwavs_options(const std::filesystem::path& folder,
                                                  const std::string& split);

}  // namespace earpoint

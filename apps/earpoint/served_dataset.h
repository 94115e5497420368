#pragma once

#include <filesystem>
#include <string>

#include <earpoint/serve/clip_library.h>

namespace earpoint {

/// Adds the clips of a data set to a library, with what the other viewpoints truly hear. In the
/// SoundSpaces layout these are what one viewpoint hears of one speaker, the whole speech, by the
/// frozen list (or the pairs that are drawn where there is none); where the data set is of
/// simulated homes, their plan is known too. In the Replay layout as add_replay_dataset().
/// @param folder  as dataset_layout() knows it
/// @throws InputError if it is none, or a file is missing or malformed
void add_dataset(const std::filesystem::path& folder, const std::string& split,
                 ClipLibrary& library);

/// Adds the clips of a data set in the Replay layout: every second once, as heard by the camera
/// that the released test draws as its source.
/// @param folder  as replay_options() knows it
/// @throws InputError if it is none, or a file is missing or malformed
void add_replay_dataset(const std::filesystem::path& folder, const std::string& split,
                        ClipLibrary& library);

}  // namespace earpoint

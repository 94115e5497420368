#pragma once

#include <filesystem>
#include <string>

#include <earpoint/serve/clip_library.h>

namespace earpoint {

/// Adds the clips of a data set's frozen list (or of the pairs that are drawn where there is none)
/// to a library: what one viewpoint hears of one speaker, the whole speech. What the other
/// viewpoints truly hear is known, and where the data set is of simulated homes, their plan too.
/// @param folder  as soundspaces_options() knows it
/// @throws InputError if it is none, or holds recordings (the layout of Replay)
void add_dataset(const std::filesystem::path& folder, const std::string& split,
                 ClipLibrary& library);

}  // namespace earpoint

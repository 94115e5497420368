#pragma once

#include <filesystem>
#include <string>

#include <earpoint/serve/listen_method.h>
#include <earpoint/serve/served_clip.h>

namespace earpoint {

/// Renders a walk through a clip into a file, as `earpoint render --path` does: the same clip, walk
/// and model give the same bytes.
/// @param walk_csv  as EarpointPath reads it
/// @param output    .wav, or .mp4 where the clip has a moving picture
/// @throws InputError if the walk is malformed or does not cover the clip, as render() and
///         open_sound_sink()
void export_walk(const ServedClip& clip, const ListenMethod& method, const std::string& walk_csv,
                 const std::filesystem::path& output);

}  // namespace earpoint

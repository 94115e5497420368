#pragma once

#include "source_arguments.h"

#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include <earpoint/gtf/weights.h>
#include <earpoint/serve/served_clip.h>

namespace earpoint {

/// Opens a recording for the page, its people and its speaker found as `earpoint render` finds
/// them.
/// @param finder    finds the speaker where nothing tells who it is; null: nobody is looked for
/// @param detector  as --detector has it
/// @param quiet     say nothing on stderr
[[nodiscard]] ServedClip open_recording(const SourceArguments& arguments, const GtfWeights* finder,
                                        const std::string& detector, bool quiet);

/// Makes a clip of a file from somebody else. A process of its own, with limits of time and memory,
/// turns it into plain sound and a picture (the hidden command that add_unpack_command() adds), so
/// that no decoder runs here on what may be meant to break it.
/// @param name  what its sender calls it
/// @throws InputError if it is nothing that can be heard
[[nodiscard]] ServedClip open_upload(const std::filesystem::path& file, const std::string& name,
                                     const GtfWeights* finder, const std::string& detector);

/// Adds `unpack FILE FOLDER`, which no help shows: writes FOLDER/sound.wav and, of a movie,
/// FOLDER/picture.png, the frame of its middle.
void add_unpack_command(CLI::App& app);

}  // namespace earpoint

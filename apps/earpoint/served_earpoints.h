#pragma once

#include <filesystem>
#include <string>

#include <earpoint/gtf/weights.h>
#include <earpoint/serve/served_clip.h>

namespace earpoint {

/// Opens a clip that comes with what was heard in other places, as examples/earpoints.json
/// describes one.
/// @param finder    finds the speaker where the description does not tell; null: nobody is looked
/// for
/// @param detector  as --detector has it
/// @param quiet     say nothing on stderr
/// @throws InputError as read_earpoint_clip(), and if a truth is not binaural
[[nodiscard]] ServedClip open_earpoints(const std::filesystem::path& description,
                                        const GtfWeights* finder, const std::string& detector,
                                        bool quiet);

}  // namespace earpoint

#pragma once

#include <cstddef>
#include <optional>

#include <earpoint/evaluate/earpoint_comparison.h>
#include <earpoint/image.h>

namespace earpoint {

/// The clip's map with the camera, the speaker, if known, and numbered earpoints drawn on it.
/// @param clip  has a map
/// @param only  the earpoint to draw; nothing: all
/// @throws InputError if the map's picture cannot be read
[[nodiscard]] Image drawn_map(const EarpointClip& clip,
                              std::optional<std::size_t> only = std::nullopt);

/// The picture in the middle of the clip with the speaker's box; an empty image if it has none.
[[nodiscard]] Image clip_picture(const EarpointClip& clip);

/// In one picture: what the camera sees, the map, and both ears of the clip and of what the last
/// method made of every earpoint.
[[nodiscard]] Image overview(const EarpointComparison& comparison);

}  // namespace earpoint

#pragma once

#include <optional>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// The picture input of a gtf network: the view of a square camera, 90 degrees wide.
struct GtfView {
  std::vector<float> picture;      ///< [3][size][size], 0 to 1; grey where the camera saw nothing
  std::optional<Box> speaker_box;  ///< in that view; nothing when out of it
};

/// Turns a camera's picture into that view; every pixel is the average over its area.
/// @param picture             RGB of any size with square pixels; null: all grey
/// @param speaker_box         in the picture
/// @param horizontal_fov_rad  of the camera, less than half a turn
/// @param size                > 0
[[nodiscard]] GtfView gtf_view(const Image* picture, const std::optional<Box>& speaker_box,
                               double horizontal_fov_rad, int size);

}  // namespace earpoint

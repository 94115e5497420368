#pragma once

#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// What ViGAS and visual acoustic matching are shown of a picture, by their engines and in
/// training: resized whatever its shape, as the released networks see it.
/// @param picture  sRGB, three channels
/// @return [3][height_px][width_px], 0 to 1
[[nodiscard]] std::vector<float> picture_planes(const Image& picture, int width_px, int height_px);

}  // namespace earpoint

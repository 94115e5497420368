#pragma once

#include <vector>

#include <earpoint/image.h>
#include <earpoint/vigas/description.h>

namespace earpoint {

/// What a network with an image encoder is shown of a picture, in training and elsewhere.
/// @param picture  sRGB, three channels
/// @return [3][height_px][width_px], 0 to 1
[[nodiscard]] std::vector<float> vigas_view(const ImageEncoderDescription& encoder,
                                            const Image& picture);

}  // namespace earpoint

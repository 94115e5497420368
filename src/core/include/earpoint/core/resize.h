#pragma once

#include <span>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// Numbers of a picture, plane by plane: [channels][height][width].
struct ImagePlanes {
  int channels = 0;
  int height = 0;
  int width = 0;
  std::vector<float> values;
};

/// @return the picture's numbers as they are, 0 to 255
ImagePlanes planes_of(const Image& image);

/// Bilinear resizing with half-pixel centres, src = (dst + 0.5) in / out - 0.5 clamped below at 0,
/// and no smoothing when it shrinks: what the released loaders do to their pictures. Returns the
/// input's numbers unchanged where the size is already right.
/// Source: torchvision 0.14, resize of tensors.
ImagePlanes resize_bilinear(const ImagePlanes& planes, int width, int height);

}  // namespace earpoint

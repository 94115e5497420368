#pragma once

#include "pixel_buffers.h"

#include <vector>

#include <earpoint/core/parallel.h>
#include <earpoint/image.h>

namespace earpoint {

/// Gives stray samples the light of a neighbouring pixel on their own surface; where there is none,
/// the mean of those in their tile that share the surface.
/// @param light  [height][width], as smooth_light gives it
void borrow_light(const std::vector<PlaceLight>& light, PixelBuffers& buffers, ThreadPool& pool);

/// @param light  [height][width], of the pixels' middles
/// @return radiance, linear; shape [height][width][3]
FloatImage put_together(const PixelBuffers& buffers, const std::vector<PlaceLight>& light);

/// What a picture's radiance is multiplied by before it is shown: brings its middle brightness near
/// that of a grey card, dark pictures a little less so than bright ones.
/// @param radiance  shape [height][width][3]
/// @return > 0; 1 for a picture without light
float find_exposure(const FloatImage& radiance);

/// The filmic curve: rises steeply from black, and bends softly towards white.
/// @param radiance  after exposure
/// @return  linear, for a screen, in [0, 1]
Rgb film_curve(const Rgb& radiance);

/// The picture as a screen shows it. Each sample goes through the curve by itself, so that edges
/// before bright windows stay smooth.
/// @return sRGB; shape [height][width][3]
Image develop(const PixelBuffers& buffers, const std::vector<PlaceLight>& light, float exposure,
              ThreadPool& pool);

}  // namespace earpoint

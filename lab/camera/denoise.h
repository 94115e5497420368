#pragma once

#include "pixel_buffers.h"

#include <vector>

#include <earpoint/core/parallel.h>

namespace earpoint {

/// The mean light of each pixel's samples on the surface of its middle; none where all strayed.
/// @return  [height][width]
std::vector<PlaceLight> mean_light(const PixelBuffers& buffers);

/// The same without its noise: a weighted mean over neighbours on the same surface, whose light
/// differs by no more than the noise explains. Colours and textures are no part of it, so they
/// stay sharp.
/// Source: edge-avoiding a-trous wavelets (Dammertz et al., HPG 2010), guided by the variance as in
/// Schied et al., HPG 2017.
/// @return  [height][width]
std::vector<PlaceLight> smooth_light(const PixelBuffers& buffers, ThreadPool& pool);

}  // namespace earpoint

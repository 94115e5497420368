#pragma once

#include <cstdint>
#include <optional>

#include <earpoint/image.h>

namespace earpoint {

/// What a camera sees, three pictures of the same size.
struct View {
  static constexpr std::int32_t kNoInstance = -1;

  Image rgb;           ///< sRGB, 8 bits
  FloatImage depth_m;  ///< along the optical axis, at the middle of each pixel (not the distance
                       ///< to the pinhole); infinite where nothing is hit
  Raster<std::int32_t> instance;  ///< index into Scene::instances, at the middle of each pixel;
                                  ///< kNoInstance where nothing is hit
};

/// The box around the pixels of one instance, e.g. a person.
/// @param min_pixels  fewer visible pixels count as hidden; > 0
/// @return the outer edges of the outermost pixels, normalised; nothing if it is hidden
std::optional<Box> visible_box(const View& view, int instance, int min_pixels);

/// Depth as a grey picture to look at: white is 0 m, black `farthest_m` and beyond.
/// @param farthest_m  > 0
/// @return shape [height][width][1]
Image picture_of_depth(const FloatImage& depth_m, double farthest_m);

/// Instances as a picture to look at: a colour of its own for each, black where there is none.
/// @return shape [height][width][3]
Image picture_of_instances(const Raster<std::int32_t>& instance);

}  // namespace earpoint

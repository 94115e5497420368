#pragma once

#include <span>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// The pixels along one axis that an output covers, each with its share of the output. The shares
/// sum to less than one where the output reaches out of the picture.
struct Cover {
  int first = 0;
  std::vector<float> shares;
};

/// @param in     pixels of the picture along this axis
/// @param out    outputs along it
/// @param start  where the first output begins, in the picture's pixels
/// @param width  of all outputs together, in the picture's pixels
[[nodiscard]] std::vector<Cover> covers(int in, int out, double start, double width);

/// Means over the areas where rows and columns cross, 0 to 1; what of them lies outside of the
/// picture is `outside`.
/// @param picture  three channels
/// @param planes   [3][rows][columns]
void area_means(const Image& picture, std::span<const Cover> rows, std::span<const Cover> columns,
                float outside, std::span<float> planes);

}  // namespace earpoint

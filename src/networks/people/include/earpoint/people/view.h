#pragma once

#include <earpoint/core/resize.h>
#include <earpoint/image.h>

namespace earpoint {

/// What a network is shown of a picture: its longer side has `longest_px`, the other is in
/// proportion, both rounded to multiples of PeopleDescription::kCoarsest. Every pixel is the
/// average over its area, less one half: -0.5 to 0.5.
/// @param picture  sRGB, three channels
[[nodiscard]] ImagePlanes people_view(const Image& picture, int longest_px);

/// A part of a picture, stretched to a size.
/// @param part  in fractions of the picture
[[nodiscard]] ImagePlanes people_view_of_part(const Image& picture, const Box& part, int width,
                                              int height);

}  // namespace earpoint

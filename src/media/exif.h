#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace earpoint {

/// What a camera noted in a picture's file. Private to the module.
struct Exif {
  int orientation = 1;                      ///< 1 (upright) to 8
  std::optional<double> focal_length_35mm;  ///< of a lens with the same diagonal view on 35 mm film
};

/// @param picture  a whole PNG or JPEG file; what cannot be read of its Exif data is left out
Exif read_exif(std::span<const std::byte> picture);

/// The horizontal angle of view of such a lens, radians.
/// @param width, height  of the picture as it is seen, > 0
/// Source: CIPA DCG-001: the equivalent focal length keeps the angle of the diagonal, 43.27 mm.
double horizontal_fov_rad(double focal_length_35mm, int width, int height);

}  // namespace earpoint

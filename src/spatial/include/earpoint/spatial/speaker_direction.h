#pragma once

#include <earpoint/image.h>
#include <earpoint/pose.h>

namespace earpoint {

/// How large a speaker is taken to be. Defaults: a standing adult.
struct PersonSize {
  double height_m = 1.70;           ///< of what the box encloses; about 1.3 for someone on a chair
  double width_m = 0.45;            ///< across the shoulders; used only where the height is cut
  double mouth_below_top_m = 0.18;  ///< from the crown of the head
};

/// Where a speaker's mouth is, seen from the camera, from the box around the person alone.
///
/// A pinhole camera with square pixels and its optical axis through the picture's middle, held
/// level; the person upright, as large as `person` says. The distance along the optical axis is
/// height_m over the box's angular height (its tangent); the azimuth is that of the box's middle;
/// the mouth lies mouth_below_top_m below the box's top.
///
/// A box that ends at the picture's edge (within 0.5 % of its size) shows only part of a person,
/// and then its height only bounds the distance from above:
/// - cut at the bottom, the top or both: the distance is the smaller one of what height and
///   width tell. (Cut at a side as well, the width too is but such a bound.)
/// - cut at the top, feet seen: the mouth is height_m - mouth_below_top_m above the box's bottom.
/// - cut at both top and bottom: the mouth is taken to be as high as the camera.
/// - cut at a side: the azimuth is that of the visible part's middle.
///
/// @param box                   normalised; x_min < x_max, y_min < y_max, within [0, 1]
/// @param horizontal_fov_rad    of the whole picture, in (0, pi)
/// @param image_width_px        > 0; with the height, only their ratio matters
/// @return  direction and distance of the mouth in the camera's frame (x front, y left, z up)
/// @throws InputError if the box is empty, outside the picture or not finite
[[nodiscard]] Spherical speaker_direction_from_box(const Box& box, double horizontal_fov_rad,
                                                   int image_width_px, int image_height_px,
                                                   const PersonSize& person = {});

}  // namespace earpoint

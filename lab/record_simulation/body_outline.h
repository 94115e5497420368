#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <earpoint/camera/camera.h>
#include <earpoint/image.h>
#include <earpoint/scene/people.h>

namespace earpoint {

/// What a camera would see of a person if nothing stood in the way.
struct BodyOutline {
  PixelRegion pixels;  ///< around the body, inside of the picture
  Box box;             ///< the same, normalised, to the fraction of a pixel
  int area = 0;        ///< pixels whose middle the body covers
};

/// @param scene   with the person in it
/// @return nothing if no pixel of the body is in the picture
std::optional<BodyOutline> outline_of(const Scene& scene, std::uint32_t instance,
                                      const Camera& camera);

}  // namespace earpoint

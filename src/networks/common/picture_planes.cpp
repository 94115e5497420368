#include <earpoint/network/picture_planes.h>

#include <utility>

#include <earpoint/core/resize.h>
#include <earpoint/error.h>

namespace earpoint {

std::vector<float> picture_planes(const Image& picture, int width_px, int height_px) {
  EARPOINT_CHECK(picture.channels() == 3 && !picture.empty());
  ImagePlanes planes = resize_bilinear(planes_of(picture), width_px, height_px);
  for (float& value : planes.values) value /= 255.0F;
  return std::move(planes.values);
}

}  // namespace earpoint

#include <earpoint/vigas/view.h>

#include <utility>

#include <earpoint/core/resize.h>
#include <earpoint/error.h>

namespace earpoint {

std::vector<float> vigas_view(const ImageEncoderDescription& encoder, const Image& picture) {
  EARPOINT_CHECK(picture.channels() == 3 && !picture.empty());
  ImagePlanes planes = resize_bilinear(planes_of(picture), encoder.width_px, encoder.height_px);
  for (float& value : planes.values) value /= 255.0F;
  return std::move(planes.values);
}

}  // namespace earpoint

#include <earpoint/camera/view.h>

#include <algorithm>
#include <cmath>

namespace earpoint {

std::optional<Box> visible_box(const View& view, int instance, int min_pixels) {
  EARPOINT_CHECK(min_pixels > 0);
  const int width = view.instance.width();
  const int height = view.instance.height();
  int x_min = width;
  int x_max = -1;
  int y_min = height;
  int y_max = -1;
  int pixels = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (view.instance.at(x, y) != instance) continue;
      ++pixels;
      x_min = std::min(x_min, x);
      x_max = std::max(x_max, x);
      y_min = std::min(y_min, y);
      y_max = std::max(y_max, y);
    }
  }
  if (pixels < min_pixels) return std::nullopt;
  return Box{.x_min = x_min / static_cast<double>(width),
             .y_min = y_min / static_cast<double>(height),
             .x_max = (x_max + 1) / static_cast<double>(width),
             .y_max = (y_max + 1) / static_cast<double>(height)};
}

Image picture_of_depth(const FloatImage& depth_m, double farthest_m) {
  EARPOINT_CHECK(farthest_m > 0.0);
  Image picture(depth_m.width(), depth_m.height(), 1);
  std::transform(depth_m.pixels().begin(), depth_m.pixels().end(), picture.pixels().begin(),
                 [&](float depth) {
                   const double near = 1.0 - std::min(1.0, depth / farthest_m);
                   return static_cast<std::uint8_t>(std::lround(255.0 * near));
                 });
  return picture;
}

Image picture_of_instances(const Raster<std::int32_t>& instance) {
  Image picture(instance.width(), instance.height(), 3);
  for (int y = 0; y < instance.height(); ++y) {
    for (int x = 0; x < instance.width(); ++x) {
      const std::int32_t index = instance.at(x, y);
      if (index == View::kNoInstance) continue;
      // Steps of the golden ratio's fraction spread the hues of neighbouring numbers.
      const double hue = 6.0 * std::fmod(0.61803398875 * (index + 1), 1.0);
      for (int channel = 0; channel < 3; ++channel) {
        const double turned = std::fmod(hue + 6.0 - 2.0 * channel, 6.0);
        const double level = std::clamp(std::abs(turned - 3.0) - 1.0, 0.0, 1.0);
        picture.at(x, y, channel) = static_cast<std::uint8_t>(std::lround(55.0 + 200.0 * level));
      }
    }
  }
  return picture;
}

}  // namespace earpoint

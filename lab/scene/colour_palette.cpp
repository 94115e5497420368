#include "colour_palette.h"

#include <algorithm>
#include <cmath>

namespace earpoint {

std::uint32_t ColourPalette::side() const {
  return std::max(1U, static_cast<std::uint32_t>(std::ceil(std::sqrt(colours_.size()))));
}

std::array<float, 2> ColourPalette::uv(std::uint32_t pixel) const {
  const double n = side();
  const std::uint32_t column = pixel % side();
  const std::uint32_t row = pixel / side();
  return {static_cast<float>((column + 0.5) / n), static_cast<float>(1.0 - (row + 0.5) / n)};
}

Image ColourPalette::texture() const {
  Image image(static_cast<int>(side()), static_cast<int>(side()), 3);
  for (std::size_t i = 0; i < colours_.size(); ++i) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const float value = std::clamp(colours_[i][channel], 0.0F, 1.0F);
      image.pixels()[3 * i + channel] = static_cast<std::uint8_t>(std::lround(255.0F * value));
    }
  }
  return image;
}

}  // namespace earpoint

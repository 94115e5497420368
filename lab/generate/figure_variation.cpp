#include <algorithm>
#include <array>
#include <cmath>

#include <earpoint/generate/people_pictures.h>

namespace earpoint {
namespace {

constexpr double kLeastSize = 0.9;
constexpr double kMostSize = 1.1;

/// Hue in [0, 6), saturation and value in [0, 1].
struct HueColour {
  double hue = 0.0;
  double saturation = 0.0;
  double value = 0.0;
};

HueColour to_hue(const std::array<double, 3>& rgb) {
  const double most = std::max({rgb[0], rgb[1], rgb[2]});
  const double range = most - std::min({rgb[0], rgb[1], rgb[2]});
  if (range <= 0.0) return {0.0, 0.0, most};
  double hue = 0.0;
  if (most == rgb[0]) {
    hue = std::fmod((rgb[1] - rgb[2]) / range + 6.0, 6.0);
  } else if (most == rgb[1]) {
    hue = (rgb[2] - rgb[0]) / range + 2.0;
  } else {
    hue = (rgb[0] - rgb[1]) / range + 4.0;
  }
  return {hue, range / most, most};
}

std::array<double, 3> to_rgb(const HueColour& colour) {
  std::array<double, 3> rgb{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double turned = std::fmod(colour.hue + 6.0 - 2.0 * static_cast<double>(i), 6.0);
    const double level = std::clamp(std::abs(turned - 3.0) - 1.0, 0.0, 1.0);
    rgb[i] = colour.value * (1.0 - colour.saturation * (1.0 - level));
  }
  return rgb;
}

/// Change of the colours of one person's clothes.
struct Recolouring {
  double hue_turn = 0.0;
  double saturation = 0.0;  ///< is added
  double gamma = 1.0;

  [[nodiscard]] std::array<double, 3> operator()(const std::array<double, 3>& rgb) const {
    HueColour colour = to_hue(rgb);
    // Skin and most hair: hues from red to yellow, moderate saturation.
    const bool is_skin = (colour.hue < 1.1 || colour.hue > 5.7) && colour.saturation > 0.12 &&
                         colour.saturation < 0.85;
    if (is_skin) return rgb;
    colour.hue = std::fmod(colour.hue + hue_turn, 6.0);
    colour.saturation = std::clamp(colour.saturation + saturation, 0.0, 1.0);
    colour.value = std::pow(colour.value, gamma);
    return to_rgb(colour);
  }
};

void recolour(Image& texture, const Recolouring& recolouring) {
  const auto pixels = texture.pixels();
  for (std::size_t i = 0; i + 2 < pixels.size(); i += 3) {
    const std::array<double, 3> rgb =
        recolouring({pixels[i] / 255.0, pixels[i + 1] / 255.0, pixels[i + 2] / 255.0});
    for (std::size_t c = 0; c < 3; ++c) {
      pixels[i + c] = static_cast<std::uint8_t>(std::lround(255.0 * rgb[c]));
    }
  }
}

}  // namespace

FigureModel varied_figure(const FigureModel& figure, RandomStream& random) {
  FigureModel varied = figure;
  const auto height = static_cast<float>(random.uniform(kLeastSize, kMostSize));
  const auto breadth = height * static_cast<float>(random.uniform(kLeastSize, kMostSize));
  for (auto& position : varied.scene.mesh.positions) {
    position[0] *= breadth;
    position[1] *= breadth;
    position[2] *= height;
  }
  varied.mouth_m = {varied.mouth_m.x * breadth, varied.mouth_m.y * breadth,
                    varied.mouth_m.z * height};
  const double hue_turn = random.uniform(0.0, 6.0);
  const double saturation = random.uniform(-0.3, 0.5);
  const double gamma = std::exp(random.uniform(-0.7, 0.7));
  const Recolouring recolouring{hue_turn, saturation, gamma};
  for (Image& texture : varied.scene.textures) recolour(texture, recolouring);
  for (Material& material : varied.scene.materials) {
    if (material.look.texture != Look::kNoTexture) continue;
    auto& colour = material.look.base_colour;
    const auto changed = recolouring({colour[0], colour[1], colour[2]});
    for (std::size_t c = 0; c < 3; ++c) colour[c] = static_cast<float>(changed[c]);
  }
  return varied;
}

}  // namespace earpoint

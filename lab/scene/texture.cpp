#include <earpoint/scene/texture.h>

#include "noise.h"

#include <algorithm>
#include <cmath>

#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

/// A point of a texture: u to the right, v upwards, both in [0, 1).
struct Spot {
  double u;
  double v;
};

ScreenColour scaled(const ScreenColour& c, double factor) {
  ScreenColour out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<float>(c[i] * factor);
  return out;
}

ScreenColour mixed(const ScreenColour& a, const ScreenColour& b, double share_of_b) {
  const auto t = static_cast<float>(std::clamp(share_of_b, 0.0, 1.0));
  ScreenColour out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = a[i] + (b[i] - a[i]) * t;
  return out;
}

double fraction(double x) { return x - std::floor(x); }

/// @return 0 in the middle of a cell, 1 at its edge
double edge(double x, double width) {
  const double f = fraction(x);
  return std::min(f, 1.0 - f) < width ? 1.0 : 0.0;
}

class TexturePainter {
 public:
  TexturePainter(const ScreenColour& colour, std::uint64_t seed) : colour_(colour), noise_(seed) {}

  [[nodiscard]] ScreenColour paint(TexturePattern pattern, Spot s) const {
    switch (pattern) {
      case TexturePattern::plaster:
        return plaster(s);
      case TexturePattern::wallpaper:
        return wallpaper(s);
      case TexturePattern::wood_planks:
        return planks(s, 8, 2);
      case TexturePattern::parquet:
        return parquet(s);
      case TexturePattern::wood_grain:
        return grain(s, colour_, 0);
      case TexturePattern::carpet:
        return carpet(s);
      case TexturePattern::tiles:
        return tiles(s);
      case TexturePattern::marble:
        return marble(s);
      case TexturePattern::concrete:
        return concrete(s);
      case TexturePattern::brick:
        return brick(s);
      case TexturePattern::linoleum:
        return linoleum(s);
      case TexturePattern::ceiling_tiles:
        return ceiling_tiles(s);
      case TexturePattern::fabric:
        return fabric(s);
      case TexturePattern::leather:
        return leather(s);
      case TexturePattern::curtain:
        return curtain(s);
      case TexturePattern::blinds:
        return scaled(colour_, 0.6 + 0.45 * fraction(s.v * 16));
      case TexturePattern::foliage:
        return foliage(s);
      case TexturePattern::rug:
        return rug(s);
      case TexturePattern::books:
        return books(s);
      case TexturePattern::painting:
        return painting(s);
      case TexturePattern::door:
        return door(s, 2);
      case TexturePattern::front_door:
        return door(s, 3);
      case TexturePattern::window_view:
        return window_view(s);
    }
    return colour_;
  }

 private:
  [[nodiscard]] double speckle(Spot s, int cells) const {
    return noise_.cell(static_cast<int>(s.u * cells), static_cast<int>(s.v * cells));
  }

  [[nodiscard]] ScreenColour plaster(Spot s) const {
    return scaled(colour_, 0.95 + 0.05 * noise_.fractal(s.u, s.v, 8, 8, 5) +
                               0.03 * noise_.smooth(s.u, s.v, 3, 3));
  }

  [[nodiscard]] ScreenColour wallpaper(Spot s) const {
    const bool dotted = noise_.cell(-1, -1) < 0.5;
    const ScreenColour other = mixed(colour_, {1, 1, 1}, 0.35);
    if (!dotted) return mixed(colour_, other, fraction(s.u * 6) < 0.5 ? 1.0 : 0.0);
    const double row = std::floor(s.v * 8);
    const double x = fraction(s.u * 8 + (std::fmod(row, 2.0) == 0.0 ? 0.0 : 0.5)) - 0.5;
    const double y = fraction(s.v * 8) - 0.5;
    const double petal = 0.2 + 0.1 * std::cos(5.0 * std::atan2(y, x));
    return mixed(colour_, other, std::hypot(x, y) < petal ? 1.0 : 0.0);
  }

  /// Wood grain along u.
  [[nodiscard]] ScreenColour grain(Spot s, const ScreenColour& tone, int board) const {
    const double shift = noise_.cell(board, 1000);
    const double wave = noise_.fractal(s.u, fraction(s.v + shift), 2, 24, 4);
    const double pore = noise_.smooth(s.u, fraction(s.v + shift), 6, 128);
    const double rings = 0.5 + 0.5 * std::sin(2.0 * kPi * 6.0 * wave);
    return scaled(tone, 0.82 + 0.12 * rings + 0.1 * pore);
  }

  [[nodiscard]] ScreenColour planks(Spot s, int rows, int per_row) const {
    const int row = static_cast<int>(s.v * rows);
    const double along = s.u * per_row + noise_.cell(row, 77);
    const int board = row * per_row + static_cast<int>(std::floor(along)) % per_row;
    const double joint = std::max(edge(s.v * rows, 0.03), edge(along, 0.006));
    const ScreenColour tone = scaled(colour_, 0.85 + 0.25 * noise_.cell(board, 5));
    return scaled(grain(s, tone, board), 1.0 - 0.45 * joint);
  }

  /// Blocks of four short boards, alternately turned by 90 degrees.
  [[nodiscard]] ScreenColour parquet(Spot s) const {
    const int i = static_cast<int>(s.u * 4);
    const int j = static_cast<int>(s.v * 4);
    const bool turned = (i + j) % 2 != 0;
    const Spot local = turned ? Spot{s.v, s.u} : s;
    const int board = static_cast<int>(local.v * 16) + 64 * (i + 4 * j);
    const double joint = std::max(edge(local.v * 16, 0.04), edge(local.u * 4, 0.01));
    const ScreenColour tone = scaled(colour_, 0.82 + 0.3 * noise_.cell(board, 5));
    return scaled(grain(local, tone, board), 1.0 - 0.4 * joint);
  }

  [[nodiscard]] ScreenColour carpet(Spot s) const {
    return scaled(colour_,
                  0.62 + 0.45 * speckle(s, 256) + 0.12 * noise_.fractal(s.u, s.v, 6, 6, 4));
  }

  [[nodiscard]] ScreenColour tiles(Spot s) const {
    const double joint = std::max(edge(s.u * 4, 0.025), edge(s.v * 4, 0.025));
    const double tone = noise_.cell(static_cast<int>(s.u * 4), static_cast<int>(s.v * 4));
    const double cloud = noise_.fractal(s.u, s.v, 6, 6, 4);
    return mixed(scaled(colour_, 0.92 + 0.05 * tone + 0.06 * cloud), {0.55F, 0.54F, 0.52F}, joint);
  }

  [[nodiscard]] ScreenColour marble(Spot s) const {
    const double bend = noise_.fractal(s.u, s.v, 3, 3, 5);
    const double vein = std::abs(std::sin(2.0 * kPi * (s.u + s.v) + 9.0 * bend));
    const double line = std::pow(1.0 - vein, 6.0);
    return mixed(scaled(colour_, 0.93 + 0.08 * bend), scaled(colour_, 0.55), 0.8 * line);
  }

  [[nodiscard]] ScreenColour concrete(Spot s) const {
    const double stain = noise_.fractal(s.u, s.v, 3, 3, 6);
    const double pore = speckle(s, 200) > 0.993 ? 0.8 : 1.0;
    return scaled(colour_, (0.82 + 0.25 * stain) * pore);
  }

  [[nodiscard]] ScreenColour brick(Spot s) const {
    const int row = static_cast<int>(s.v * 12);
    const double along = s.u * 4 + (row % 2 == 0 ? 0.0 : 0.5);
    const double joint = std::max(edge(s.v * 12, 0.08), edge(along, 0.025));
    const double tone = noise_.cell(static_cast<int>(along) % 4, row);
    const ScreenColour stone =
        scaled(colour_, 0.75 + 0.35 * tone + 0.15 * noise_.fractal(s.u, s.v, 24, 24, 3) - 0.07);
    return mixed(stone, {0.72F, 0.70F, 0.66F}, joint);
  }

  [[nodiscard]] ScreenColour linoleum(Spot s) const {
    return scaled(colour_, 0.9 + 0.1 * noise_.fractal(s.u, s.v, 16, 16, 4) +
                               (speckle(s, 160) > 0.9 ? 0.06 : 0.0));
  }

  [[nodiscard]] ScreenColour ceiling_tiles(Spot s) const {
    const double joint = std::max(edge(s.u * 2, 0.012), edge(s.v * 2, 0.012));
    const double hole = speckle(s, 110) > 0.9 ? 0.75 : 1.0;
    return scaled(colour_, (1.0 - 0.35 * joint) * hole);
  }

  [[nodiscard]] ScreenColour fabric(Spot s) const {
    const double weave =
        0.5 + 0.25 * std::sin(2.0 * kPi * 48 * s.u) + 0.25 * std::sin(2.0 * kPi * 48 * s.v);
    return scaled(
        colour_, 0.8 + 0.14 * weave + 0.1 * speckle(s, 128) + 0.06 * noise_.smooth(s.u, s.v, 4, 4));
  }

  [[nodiscard]] ScreenColour leather(Spot s) const {
    const double wrinkle = std::abs(noise_.fractal(s.u, s.v, 20, 20, 3) - 0.5) * 2.0;
    return scaled(colour_, 0.82 + 0.25 * wrinkle);
  }

  [[nodiscard]] ScreenColour curtain(Spot s) const {
    const double sway = 0.15 * noise_.smooth(s.u, s.v, 4, 2);
    const double fold = 0.5 + 0.5 * std::sin(2.0 * kPi * (6.0 * s.u + sway));
    return scaled(colour_, 0.62 + 0.38 * fold + 0.05 * speckle(s, 200));
  }

  [[nodiscard]] ScreenColour foliage(Spot s) const {
    const double leaf = noise_.fractal(s.u, s.v, 12, 12, 4);
    return scaled(colour_, 0.35 + 1.1 * std::max(0.0, leaf - 0.15));
  }

  [[nodiscard]] ScreenColour rug(Spot s) const {
    const double border = std::min({s.u, s.v, 1.0 - s.u, 1.0 - s.v});
    const ScreenColour accent = mixed(colour_, {0.93F, 0.87F, 0.72F}, 0.75);
    const ScreenColour dark = scaled(colour_, 0.55);
    ScreenColour tone = colour_;
    if (border < 0.03 || (border > 0.09 && border < 0.11)) tone = accent;
    if (border >= 0.03 && border <= 0.09) tone = dark;
    if (border > 0.11) {
      const double x = std::abs(fraction(s.u * 5) - 0.5);
      const double y = std::abs(fraction(s.v * 5) - 0.5);
      if (x + y < 0.32) tone = accent;
      if (x + y < 0.18) tone = dark;
    }
    return scaled(tone, 0.75 + 0.35 * speckle(s, 200));
  }

  [[nodiscard]] ScreenColour books(Spot s) const {
    const int shelf = static_cast<int>(s.v * 5);
    const double height = fraction(s.v * 5);
    if (height < 0.07) return grain(s, colour_, shelf);
    const int spine = static_cast<int>(s.u * 34) + 100 * shelf;
    const double top = 0.68 + 0.25 * noise_.cell(spine, 3);
    if (height > top) return scaled(colour_, 0.25);
    const ScreenColour tone = {static_cast<float>(0.15 + 0.7 * noise_.cell(spine, 1)),
                               static_cast<float>(0.12 + 0.5 * noise_.cell(spine, 2)),
                               static_cast<float>(0.12 + 0.5 * noise_.cell(spine, 4))};
    const double rounding = std::sin(kPi * fraction(s.u * 34));
    const bool title = height > 0.3 && height < 0.36;
    return scaled(title ? mixed(tone, {0.9F, 0.85F, 0.6F}, 0.6) : tone, 0.45 + 0.55 * rounding);
  }

  [[nodiscard]] ScreenColour painting(Spot s) const {
    const double border = std::min({s.u, s.v, 1.0 - s.u, 1.0 - s.v});
    if (border < 0.05) return scaled(colour_, 0.45);
    const double hill = 0.35 + 0.3 * noise_.fractal(s.u, 0.3, 4, 4, 3);
    const double far_hill = 0.5 + 0.25 * noise_.fractal(s.u, 0.7, 3, 3, 3);
    const ScreenColour sky = mixed({0.95F, 0.85F, 0.7F}, {0.5F, 0.65F, 0.85F}, s.v);
    const double brush = 0.85 + 0.3 * noise_.fractal(s.u, s.v, 30, 30, 2);
    if (s.v < hill) return scaled(mixed(colour_, {0.25F, 0.4F, 0.2F}, 0.5), brush);
    if (s.v < far_hill) return scaled(mixed(colour_, {0.5F, 0.5F, 0.6F}, 0.6), brush);
    return scaled(sky, brush);
  }

  /// Panels in a frame, a handle on the side of high u.
  [[nodiscard]] ScreenColour door(Spot s, int panels) const {
    if (std::hypot((s.u - 0.92) * 0.45, s.v - 0.5) < 0.012) return {0.75F, 0.72F, 0.65F};
    if (s.u > 0.83 && s.u < 0.93 && std::abs(s.v - 0.5) < 0.006) return {0.75F, 0.72F, 0.65F};
    const ScreenColour wood = scaled(grain({s.v, s.u}, colour_, 0), 1.06);
    const double row = fraction((s.v - 0.06) / 0.9 * panels);
    const bool inside = s.u > 0.16 && s.u < 0.84 && s.v > 0.06 && s.v < 0.96;
    const double u_edge = std::min(s.u - 0.16, 0.84 - s.u) / 0.03;
    const double v_edge = std::min(row - 0.08, 0.92 - row) * (0.9 / panels) / 0.014;
    const double bevel = std::min(u_edge, v_edge);
    if (!inside || bevel < 0.0) return wood;
    if (bevel < 1.0) return scaled(wood, v_edge < u_edge && row > 0.5 ? 1.12 : 0.72);
    return scaled(wood, 0.95);
  }

  [[nodiscard]] ScreenColour window_view(Spot s) const {
    const double cloud = noise_.fractal(s.u, s.v, 3, 5, 5);
    const ScreenColour sky = mixed(mixed({0.98F, 0.97F, 0.95F}, {0.55F, 0.73F, 0.95F}, s.v * 1.2),
                                   {1, 1, 1}, 1.6 * (cloud - 0.45));
    const double roofs =
        0.22 + 0.12 * std::floor(4.0 * noise_.cell(static_cast<int>(s.u * 5), 9)) / 4;
    const double trees = 0.16 + 0.16 * noise_.fractal(s.u, 0.5, 8, 8, 4);
    if (s.v < trees) {
      return scaled({0.42F, 0.55F, 0.33F}, 0.7 + 0.6 * noise_.fractal(s.u, s.v, 32, 32, 3));
    }
    if (s.v < roofs) return mixed(colour_, {0.8F, 0.75F, 0.7F}, 0.7);
    return sky;
  }

  ScreenColour colour_;
  PeriodicNoise noise_;
};

}  // namespace

std::array<float, 3> linear_colour(const ScreenColour& colour) {
  std::array<float, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double c = colour[i];
    out[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return out;
}

Image make_texture(TexturePattern pattern, const ScreenColour& colour, std::uint64_t seed,
                   int pixels) {
  EARPOINT_CHECK(pixels > 0);
  const TexturePainter painter(colour, seed);
  Image image(pixels, pixels, 3);
  for (int y = 0; y < pixels; ++y) {
    for (int x = 0; x < pixels; ++x) {
      const ScreenColour c =
          painter.paint(pattern, {(x + 0.5) / pixels, (pixels - y - 0.5) / pixels});
      for (int channel = 0; channel < 3; ++channel) {
        const float value = std::clamp(c[static_cast<std::size_t>(channel)], 0.0F, 1.0F);
        image.at(x, y, channel) = static_cast<std::uint8_t>(std::lround(value * 255.0F));
      }
    }
  }
  return image;
}

double texture_span_m(TexturePattern pattern) {
  switch (pattern) {
    case TexturePattern::wood_planks:
      return 1.2;
    case TexturePattern::parquet:
      return 1.0;
    case TexturePattern::tiles:
      return 1.2;
    case TexturePattern::marble:
      return 1.6;
    case TexturePattern::concrete:
      return 2.0;
    case TexturePattern::plaster:
      return 1.5;
    case TexturePattern::brick:
      return 0.95;
    case TexturePattern::ceiling_tiles:
      return 1.2;
    case TexturePattern::carpet:
      return 0.6;
    case TexturePattern::fabric:
      return 0.3;
    case TexturePattern::leather:
      return 0.6;
    case TexturePattern::foliage:
      return 0.5;
    default:
      return 1.0;
  }
}

}  // namespace earpoint

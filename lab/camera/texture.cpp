#include "texture.h"

#include <array>
#include <cmath>

namespace earpoint {
namespace {

double srgb_to_linear(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double linear_to_srgb(double value) {
  return value <= 0.0031308 ? value * 12.92 : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
}

const std::array<float, 256>& linear_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (int i = 0; i < 256; ++i) values[i] = static_cast<float>(srgb_to_linear(i / 255.0));
    return values;
  }();
  return table;
}

// Steps of linear light that are fine enough for the steepest part of the curve: 12.92 * 255 / 8192
// is 0.4 of an 8-bit step.
constexpr int kSrgbSteps = 8192;

const std::array<std::uint8_t, kSrgbSteps + 1>& srgb_table() {
  static const std::array<std::uint8_t, kSrgbSteps + 1> table = [] {
    std::array<std::uint8_t, kSrgbSteps + 1> values{};
    for (int i = 0; i <= kSrgbSteps; ++i) {
      const double linear = static_cast<double>(i) / kSrgbSteps;
      values[i] = static_cast<std::uint8_t>(std::lround(255.0 * linear_to_srgb(linear)));
    }
    return values;
  }();
  return table;
}

Rgb linear_texel(const std::uint8_t* texel) {
  const std::array<float, 256>& table = linear_table();
  return {table[texel[0]], table[texel[1]], table[texel[2]]};
}

}  // namespace

float linear_from_srgb(std::uint8_t value) { return linear_table()[value]; }

std::uint8_t srgb_from_linear(float linear) {
  const float clamped = std::clamp(linear, 0.0F, 1.0F);
  return srgb_table()[static_cast<std::size_t>(std::lrintf(clamped * kSrgbSteps))];
}

Texture::Texture(const Image& image) {
  EARPOINT_CHECK(!image.empty() && image.channels() == 3);
  Level level{image.width(), image.height(), {}};
  const std::size_t pixels = static_cast<std::size_t>(level.width) * level.height;
  level.texels.resize(4 * pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) level.texels[4 * i + c] = image.pixels()[3 * i + c];
  }
  levels_.push_back(std::move(level));

  // Each copy has half the size, rounded up; the last pixel of an odd row counts for two.
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& large = levels_.back();
    Level small{(large.width + 1) / 2, (large.height + 1) / 2, {}};
    small.texels.resize(4 * static_cast<std::size_t>(small.width) * small.height);
    for (int y = 0; y < small.height; ++y) {
      for (int x = 0; x < small.width; ++x) {
        Rgb sum;
        for (int corner = 0; corner < 4; ++corner) {
          const int from_x = std::min(2 * x + (corner & 1), large.width - 1);
          const int from_y = std::min(2 * y + (corner >> 1), large.height - 1);
          sum += linear_texel(
              &large.texels[4 * (static_cast<std::size_t>(from_y) * large.width + from_x)]);
        }
        std::uint8_t* texel = &small.texels[4 * (static_cast<std::size_t>(y) * small.width + x)];
        texel[0] = srgb_from_linear(0.25F * sum.x);
        texel[1] = srgb_from_linear(0.25F * sum.y);
        texel[2] = srgb_from_linear(0.25F * sum.z);
      }
    }
    levels_.push_back(std::move(small));
  }
  mean_ = linear_texel(levels_.back().texels.data());
}

Rgb Texture::sample(float u, float v, float width) const {
  // The copy whose pixels are about as wide as the spot: log2 of it, rounded.
  int number = 0;
  if (width > 1.0F) {
    number = std::min(std::ilogb(width * 1.41421356F), static_cast<int>(levels_.size()) - 1);
  }
  const Level& level = levels_[static_cast<std::size_t>(number)];
  const float x = (u - std::floor(u)) * static_cast<float>(level.width) - 0.5F;
  const float y = (1.0F - (v - std::floor(v))) * static_cast<float>(level.height) - 0.5F;
  // Both are -1/2 or more.
  const int left = static_cast<int>(x + 1.0F) - 1;
  const int top = static_cast<int>(y + 1.0F) - 1;
  const float fraction_x = x - static_cast<float>(left);
  const float fraction_y = y - static_cast<float>(top);
  const int x0 = left < 0 ? level.width - 1 : left;
  const int y0 = top < 0 ? level.height - 1 : top;
  const int x1 = x0 + 1 == level.width ? 0 : x0 + 1;
  const int y1 = y0 + 1 == level.height ? 0 : y0 + 1;
  const auto texel = [&](int column, int row) {
    return linear_texel(&level.texels[4 * (static_cast<std::size_t>(row) * level.width + column)]);
  };
  const Rgb upper = texel(x0, y0) * (1.0F - fraction_x) + texel(x1, y0) * fraction_x;
  const Rgb lower = texel(x0, y1) * (1.0F - fraction_x) + texel(x1, y1) * fraction_x;
  return upper * (1.0F - fraction_y) + lower * fraction_y;
}

}  // namespace earpoint

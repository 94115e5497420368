#pragma once

#include "float3.h"

#include <cstdint>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// A picture that repeats, with ever smaller copies of itself for far surfaces.
class Texture {
 public:
  /// @param image  RGB, sRGB; not empty
  explicit Texture(const Image& image);

  /// The linear colour at a place, bilinear between pixels of one copy.
  /// @param uv     one unit is one picture; v points up
  /// @param width  how wide a spot to look at, in pixels of the largest copy
  [[nodiscard]] Rgb sample(float u, float v, float width) const;

  /// The linear colour of the whole picture.
  [[nodiscard]] Rgb mean() const { return mean_; }
  [[nodiscard]] int width() const { return levels_.front().width; }
  [[nodiscard]] int height() const { return levels_.front().height; }

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> texels;  // [height][width][4], sRGB, the fourth unused
  };

  std::vector<Level> levels_;
  Rgb mean_;
};

/// Linear light of an 8-bit sRGB value (IEC 61966-2-1).
float linear_from_srgb(std::uint8_t value);

/// @param linear  clamped to [0, 1]
std::uint8_t srgb_from_linear(float linear);

}  // namespace earpoint

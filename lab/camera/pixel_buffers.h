#pragma once

#include "float3.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace earpoint {

/// The light of a place, in parts that differ in how they change from place to place.
struct PlaceLight {
  static constexpr std::size_t kParts = 3;
  enum Part : std::size_t {
    direct,    ///< irradiance from lamps and shining surfaces
    indirect,  ///< irradiance from all others
    gloss      ///< radiance of blurred reflections
  };
  std::array<Rgb, kParts> parts;

  [[nodiscard]] Rgb irradiance() const { return parts[direct] + parts[indirect]; }
};

/// What the middle of a pixel shows; guides the smoothing of the light.
struct Guide {
  bool lit = false;  ///< a surface, not the sky
  Float3 position;   ///< of what is seen, through mirrors
  Float3 normal;
  float footprint_m = 0.0F;  ///< width of the pixel there
};

/// The sum of those samples of a pixel that lie on the surface of its middle.
struct PixelSum {
  std::uint32_t samples = 0;
  Rgb albedo;
  Rgb added;  ///< radiance without noise: emission, sky, sharp reflections
  PlaceLight light;
  std::array<float, PlaceLight::kParts> squares{};  ///< sums of squares of the luminance
};

/// A sample that lies on another surface than the middle of its pixel.
struct StraySample {
  std::uint32_t pixel = 0;
  Guide place;
  Rgb albedo;
  Rgb added;
  PlaceLight light;
};

/// A picture before it is put together.
struct PixelBuffers {
  int width = 0;
  int height = 0;
  int samples = 1;                               ///< per pixel
  std::vector<Guide> guides;                     // [height][width]
  std::vector<PixelSum> sums;                    // [height][width]
  std::vector<std::vector<StraySample>> strays;  // [tiles]
};

/// How far two places are on one surface: 1 the same, 0 different ones.
/// @param reach  how many footprints apart they may lie
inline float same_surface(const Guide& a, const Guide& b, float reach) {
  if (a.lit != b.lit) return 0.0F;
  if (!a.lit) return 1.0F;
  const float turn = dot(a.normal, b.normal);
  if (turn < 0.8F) return 0.0F;
  const float apart = std::abs(dot(a.normal, b.position - a.position));
  const float x = apart / (reach * a.footprint_m);
  return x < 1.0F ? (1.0F - x * x) * turn : 0.0F;
}

}  // namespace earpoint

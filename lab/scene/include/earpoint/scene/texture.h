#pragma once

#include <array>
#include <cstdint>

#include <earpoint/image.h>

namespace earpoint {

/// A colour as one mixes it on a screen: sRGB, red, green, blue in [0, 1].
using ScreenColour = std::array<float, 3>;

/// @return the same colour in linear light, as Look::base_colour wants it
std::array<float, 3> linear_colour(const ScreenColour& colour);

/// What a surface looks like from near. All but the pictures repeat without a seam.
enum class TexturePattern {
  plaster,
  wallpaper,
  wood_planks,
  parquet,
  wood_grain,
  carpet,
  tiles,
  marble,
  concrete,
  brick,
  linoleum,
  ceiling_tiles,
  fabric,
  leather,
  curtain,  ///< folds run upwards
  blinds,
  foliage,
  rug,          ///< a picture of a whole rug
  books,        ///< a picture of a shelf
  painting,     ///< a picture
  door,         ///< a picture of a door leaf
  front_door,   ///< a picture of a front door
  window_view,  ///< a picture of sky, trees and houses
};

/// Draws a texture from noise and simple shapes; nothing is loaded.
/// @param colour  the main colour; the pattern varies around it
/// @param seed    the same seed gives the same pixels
/// @param pixels  of each side, > 0
/// @return shape [pixels][pixels][3]
Image make_texture(TexturePattern pattern, const ScreenColour& colour, std::uint64_t seed,
                   int pixels = 256);

/// @return what a texture of this pattern spans in a room, metres; 1 for pictures
double texture_span_m(TexturePattern pattern);

}  // namespace earpoint

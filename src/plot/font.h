#pragma once

// The letters of draw_text, as strokes. Private to the module.

#include <vector>

#include <earpoint/plot/draw.h>

namespace earpoint {

/// A letter in its own units, y upwards from the baseline: capitals are 8 high, small letters 5.6,
/// descenders reach to -2.4.
struct Glyph {
  double width = 0.0;
  std::vector<std::vector<Point>> strokes;
};

/// @param character  any but printable ASCII gives the question mark
const Glyph& glyph_of(char character);

}  // namespace earpoint

#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include <earpoint/image.h>

namespace earpoint {

/// Drawing on RGB pictures, shape [height][width][3]. Coordinates are pixels, x to the right and y
/// downwards; the pixel in column i covers [i, i + 1), so that its middle is at i + 0.5. What lies
/// outside the picture is left out. A picture that is not RGB is a std::logic_error.

struct Color {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;

  friend constexpr bool operator==(const Color&, const Color&) = default;
};

/// @param fraction  0 gives a, 1 gives b
Color mix(Color a, Color b, double fraction);

struct Point {
  double x = 0.0;
  double y = 0.0;
};

/// Whole pixels: columns [x, x + width), rows [y, y + height).
struct PixelRect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// A picture of one colour.
[[nodiscard]] Image filled_image(int width, int height, Color color);

/// @param opacity  0 leaves what is there, 1 covers it
void fill_rect(Image& image, const PixelRect& rect, Color color, double opacity = 1.0);

/// A frame one pixel wide, just inside the rectangle.
void outline_rect(Image& image, const PixelRect& rect, Color color);

/// A stroke through the points, antialiased, with round joints and ends. Where it crosses itself it
/// is no darker. One point is a dot.
/// @param width  of the stroke, in pixels, > 0
void draw_polyline(Image& image, std::span<const Point> points, Color color, double width = 1.0);

void draw_line(Image& image, Point from, Point to, Color color, double width = 1.0);

/// A vertical bar over one column from y = top to y = bottom, its ends antialiased: what waveforms
/// are drawn of. Bars thinner than a pixel are drawn a pixel high.
void draw_column(Image& image, int x, double top, double bottom, Color color, double opacity = 1.0);

/// Puts a picture onto another, its upper left corner at (x, y).
void paste(Image& canvas, const Image& image, int x, int y);

enum class TextAlign { left, centre, right };

/// How text looks. Letters are strokes, antialiased at any size.
struct TextStyle {
  double size = 12.0;  ///< height of capitals and figures is 0.7 of it; pixels
  Color color = {};    ///< black
  bool is_bold = false;
  TextAlign align = TextAlign::left;
};

/// Writes one line of text. ASCII; any other character is drawn as a question mark.
/// @param anchor  on the baseline: the text's left end, middle or right end, as align says
void draw_text(Image& image, Point anchor, std::string_view text, const TextStyle& style);

/// @return  pixels from the first letter's left to the last one's right
[[nodiscard]] double text_width(std::string_view text, const TextStyle& style);

}  // namespace earpoint

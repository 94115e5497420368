#include <earpoint/plot/draw.h>

#include "font.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kUnitsPerSize = 11.4;  // font units in a text's size: capitals of 8 are 0.7 of it
constexpr double kLetterGap = 1.7;      // font units
constexpr double kStroke = 0.95;        // font units
constexpr double kBoldStroke = 1.5;

std::uint8_t blend_channel(std::uint8_t below, std::uint8_t above, double opacity) {
  return static_cast<std::uint8_t>(std::lround(below + (above - below) * opacity));
}

void blend(Image& image, int x, int y, Color color, double opacity) {
  image.at(x, y, 0) = blend_channel(image.at(x, y, 0), color.red, opacity);
  image.at(x, y, 1) = blend_channel(image.at(x, y, 1), color.green, opacity);
  image.at(x, y, 2) = blend_channel(image.at(x, y, 2), color.blue, opacity);
}

double distance_to_segment(Point p, Point a, Point b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double length_squared = dx * dx + dy * dy;
  double along = 0.0;
  if (length_squared > 0.0) {
    along = std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length_squared, 0.0, 1.0);
  }
  return std::hypot(p.x - a.x - along * dx, p.y - a.y - along * dy);
}

/// The pixels [first, last) of a picture's side that a stroke over [low, high] can reach.
struct PixelRange {
  PixelRange(double low, double high, double reach, int size)
      : first(static_cast<int>(std::clamp(std::floor(low - reach), 0.0, 1.0 * size))),
        last(static_cast<int>(std::clamp(std::ceil(high + reach), 0.0, 1.0 * size))) {}
  int first;
  int last;
};

/// How much of each pixel a set of strokes covers. Strokes that meet cover a pixel once.
class StrokeMask {
 public:
  /// For strokes of that width with points in the box from `low` to `high`.
  StrokeMask(const Image& image, Point low, Point high, double width)
      : half_width_(width / 2.0),
        columns_(low.x, high.x, reach(), image.width()),
        rows_(low.y, high.y, reach(), image.height()),
        stride_(static_cast<std::size_t>(std::max(0, columns_.last - columns_.first))),
        coverage_(stride_ * static_cast<std::size_t>(std::max(0, rows_.last - rows_.first))) {}

  void add_segment(Point a, Point b) {
    const PixelRange columns(std::min(a.x, b.x), std::max(a.x, b.x), reach(), columns_.last);
    const PixelRange rows(std::min(a.y, b.y), std::max(a.y, b.y), reach(), rows_.last);
    for (int y = std::max(rows.first, rows_.first); y < rows.last; ++y) {
      for (int x = std::max(columns.first, columns_.first); x < columns.last; ++x) {
        const double distance = distance_to_segment({x + 0.5, y + 0.5}, a, b);
        const double covered = std::clamp(half_width_ + 0.5 - distance, 0.0, 1.0);
        float& value = at(x, y);
        value = std::max(value, static_cast<float>(covered));
      }
    }
  }

  void paint(Image& image, Color color) {
    for (int y = rows_.first; y < rows_.last; ++y) {
      for (int x = columns_.first; x < columns_.last; ++x) {
        const float covered = at(x, y);
        if (covered > 0.0F) blend(image, x, y, color, covered);
      }
    }
  }

 private:
  [[nodiscard]] double reach() const { return half_width_ + 1.0; }
  float& at(int x, int y) {
    return coverage_[static_cast<std::size_t>(y - rows_.first) * stride_ +
                     static_cast<std::size_t>(x - columns_.first)];
  }

  double half_width_;
  PixelRange columns_;
  PixelRange rows_;
  std::size_t stride_;
  std::vector<float> coverage_;
};

void draw_strokes(Image& image, const std::vector<std::vector<Point>>& strokes, Color color,
                  double width) {
  Point low{1e9, 1e9};
  Point high{-1e9, -1e9};
  for (const auto& stroke : strokes) {
    for (const Point& point : stroke) {
      EARPOINT_CHECK(std::isfinite(point.x) && std::isfinite(point.y));
      low = {std::min(low.x, point.x), std::min(low.y, point.y)};
      high = {std::max(high.x, point.x), std::max(high.y, point.y)};
    }
  }
  StrokeMask mask(image, low, high, width);
  for (const auto& stroke : strokes) {
    if (stroke.size() == 1) mask.add_segment(stroke[0], stroke[0]);
    for (std::size_t i = 1; i < stroke.size(); ++i) mask.add_segment(stroke[i - 1], stroke[i]);
  }
  mask.paint(image, color);
}

}  // namespace

Color mix(Color a, Color b, double fraction) {
  return {blend_channel(a.red, b.red, fraction), blend_channel(a.green, b.green, fraction),
          blend_channel(a.blue, b.blue, fraction)};
}

Image filled_image(int width, int height, Color color) {
  Image image(width, height, 3);
  fill_rect(image, {0, 0, width, height}, color);
  return image;
}

void fill_rect(Image& image, const PixelRect& rect, Color color, double opacity) {
  EARPOINT_CHECK(image.channels() == 3);
  const int x_end = std::min(rect.x + rect.width, image.width());
  const int y_end = std::min(rect.y + rect.height, image.height());
  for (int y = std::max(rect.y, 0); y < y_end; ++y) {
    for (int x = std::max(rect.x, 0); x < x_end; ++x) blend(image, x, y, color, opacity);
  }
}

void outline_rect(Image& image, const PixelRect& rect, Color color) {
  fill_rect(image, {rect.x, rect.y, rect.width, 1}, color);
  fill_rect(image, {rect.x, rect.y + rect.height - 1, rect.width, 1}, color);
  fill_rect(image, {rect.x, rect.y + 1, 1, rect.height - 2}, color);
  fill_rect(image, {rect.x + rect.width - 1, rect.y + 1, 1, rect.height - 2}, color);
}

void draw_polyline(Image& image, std::span<const Point> points, Color color, double width) {
  EARPOINT_CHECK(image.channels() == 3 && width > 0.0);
  if (points.empty()) return;
  draw_strokes(image, {std::vector<Point>(points.begin(), points.end())}, color, width);
}

void draw_line(Image& image, Point from, Point to, Color color, double width) {
  const Point points[] = {from, to};
  draw_polyline(image, points, color, width);
}

void draw_column(Image& image, int x, double top, double bottom, Color color, double opacity) {
  EARPOINT_CHECK(image.channels() == 3);
  if (x < 0 || x >= image.width()) return;
  if (bottom - top < 1.0) {
    const double middle = 0.5 * (top + bottom);
    top = middle - 0.5;
    bottom = middle + 0.5;
  }
  const PixelRange rows(top, bottom, 0.0, image.height());
  for (int y = rows.first; y < rows.last; ++y) {
    const double covered = std::min(bottom, y + 1.0) - std::max(top, 1.0 * y);
    if (covered > 0.0) blend(image, x, y, color, opacity * covered);
  }
}

void paste(Image& canvas, const Image& image, int x, int y) {
  EARPOINT_CHECK(canvas.channels() == 3 && image.channels() == 3);
  const int columns_end = std::min(image.width(), canvas.width() - x);
  const int rows_end = std::min(image.height(), canvas.height() - y);
  for (int row = std::max(0, -y); row < rows_end; ++row) {
    for (int column = std::max(0, -x); column < columns_end; ++column) {
      for (int c = 0; c < 3; ++c) canvas.at(x + column, y + row, c) = image.at(column, row, c);
    }
  }
}

double text_width(std::string_view text, const TextStyle& style) {
  double units = 0.0;
  for (const char character : text) units += glyph_of(character).width + kLetterGap;
  return text.empty() ? 0.0 : (units - kLetterGap) * style.size / kUnitsPerSize;
}

void draw_text(Image& image, Point anchor, std::string_view text, const TextStyle& style) {
  EARPOINT_CHECK(image.channels() == 3 && style.size > 0.0);
  const double scale = style.size / kUnitsPerSize;
  double x = anchor.x;
  if (style.align == TextAlign::centre) x -= text_width(text, style) / 2.0;
  if (style.align == TextAlign::right) x -= text_width(text, style);
  for (const char character : text) {
    const Glyph& glyph = glyph_of(character);
    std::vector<std::vector<Point>> strokes = glyph.strokes;
    for (auto& stroke : strokes) {
      for (Point& point : stroke) point = {x + scale * point.x, anchor.y - scale * point.y};
    }
    const double width = scale * (style.is_bold ? kBoldStroke : kStroke);
    // Below a pixel strokes would turn grey before they turn thin.
    draw_strokes(image, strokes, style.color, std::max(width, 1.0));
    x += (glyph.width + kLetterGap) * scale;
  }
}

}  // namespace earpoint

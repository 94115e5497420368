#pragma once

// Axes of plots. Private to the module.

#include <string>
#include <vector>

#include <earpoint/plot/draw.h>

namespace earpoint {

/// The colours of every plot.
constexpr Color kPaper = {255, 255, 255};
constexpr Color kInk = {38, 42, 51};
constexpr Color kFaintInk = {110, 116, 128};
constexpr Color kGrid = {226, 229, 235};

/// A linear scale from values to pixels.
struct Axis {
  double low = 0.0;  ///< the value at pixel `from`
  double high = 1.0;
  double from = 0.0;
  double to = 1.0;

  [[nodiscard]] double pixel(double value) const {
    return from + (value - low) / (high - low) * (to - from);
  }
};

struct Tick {
  double value = 0.0;
  std::string text;
};

/// Round values (1, 2 or 5 times a power of ten apart) within [low, high], at most `most` of them.
/// @param most  >= 2
std::vector<Tick> ticks(double low, double high, int most);

/// Ticks of a horizontal axis, far enough apart for their numbers.
std::vector<Tick> time_ticks(const Axis& time_s);

/// Numbers and marks under a plot, and what they mean.
void draw_time_axis(Image& image, const Axis& time_s, int y);

/// The title over a plot.
void draw_title(Image& image, int x, const std::string& title);

}  // namespace earpoint

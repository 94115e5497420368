#include "training_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <earpoint/plot/draw.h>

namespace earpoint {
namespace {

constexpr int kWidth = 900;
constexpr int kPanelHeight = 280;
constexpr PixelRect kArea{70, 40, kWidth - 100, kPanelHeight - 80};
constexpr Color kInk{60, 60, 60};
constexpr Color kGrid{225, 225, 225};
constexpr Color kPale{190, 210, 235};
constexpr Color kLine{30, 90, 180};
constexpr int kTicks = 4;

/// Bounds of a panel's axes.
struct Bounds {
  double most_clips = 1.0;
  double low = 0.0;
  double high = 1.0;

  [[nodiscard]] Point at(const CurvePoint& point, int top) const {
    return {kArea.x + kArea.width * point.clips / most_clips,
            top + kArea.y + kArea.height * (1.0 - (point.value - low) / (high - low))};
  }
};

Bounds bounds_of(const std::vector<CurvePoint>& curve, double most_clips) {
  Bounds bounds{std::max(most_clips, 1.0), std::numeric_limits<double>::infinity(),
                -std::numeric_limits<double>::infinity()};
  for (const CurvePoint& point : curve) {
    if (!std::isfinite(point.value)) continue;
    bounds.low = std::min(bounds.low, point.value);
    bounds.high = std::max(bounds.high, point.value);
  }
  if (!(bounds.low <= bounds.high)) bounds.low = bounds.high = 0.0;
  const double margin = std::max(0.05 * (bounds.high - bounds.low), 1e-6);
  bounds.low -= margin;
  bounds.high += margin;
  return bounds;
}

/// Means of points, at most `most` of them: one per column of a panel.
std::vector<CurvePoint> thinned(const std::vector<CurvePoint>& curve, std::size_t most) {
  std::vector<CurvePoint> means;
  const std::size_t each = (curve.size() + most - 1) / std::max<std::size_t>(most, 1);
  for (std::size_t start = 0; start < curve.size(); start += each) {
    const std::size_t end = std::min(start + each, curve.size());
    CurvePoint mean;
    for (std::size_t i = start; i < end; ++i) {
      mean.clips += curve[i].clips / static_cast<double>(end - start);
      mean.value += curve[i].value / static_cast<double>(end - start);
    }
    means.push_back(mean);
  }
  return means;
}

void draw_curve(Image& image, const std::vector<CurvePoint>& curve, const Bounds& bounds, int top,
                Color color, double width) {
  std::vector<Point> points;
  for (const CurvePoint& point : curve) {
    if (std::isfinite(point.value)) points.push_back(bounds.at(point, top));
  }
  if (!points.empty()) draw_polyline(image, points, color, width);
}

void draw_axes(Image& image, const Bounds& bounds, int top, const std::string& title) {
  for (int i = 0; i <= kTicks; ++i) {
    const double part = static_cast<double>(i) / kTicks;
    const CurvePoint tick{bounds.most_clips * part, bounds.low + (bounds.high - bounds.low) * part};
    const Point at = bounds.at(tick, top);
    draw_line(image, {static_cast<double>(kArea.x), at.y},
              {static_cast<double>(kArea.x + kArea.width), at.y}, kGrid);
    draw_text(image, {kArea.x - 6.0, at.y + 4.0}, fmt::format("{:.4g}", tick.value),
              {.size = 12, .color = kInk, .align = TextAlign::right});
    draw_text(image, {at.x, top + kArea.y + kArea.height + 18.0}, fmt::format("{:.4g}", tick.clips),
              {.size = 12, .color = kInk, .align = TextAlign::centre});
  }
  draw_text(image, {static_cast<double>(kArea.x), top + 26.0}, title,
            {.size = 15, .color = kInk, .is_bold = true});
  draw_text(image, {static_cast<double>(kArea.x + kArea.width), top + kPanelHeight - 6.0},
            "clips seen", {.size = 12, .color = kInk, .align = TextAlign::right});
}

}  // namespace

Image plot_training(const std::vector<CurvePoint>& losses, const std::vector<CurvePoint>& errors,
                    const std::string& error_name) {
  Image image = filled_image(kWidth, 2 * kPanelHeight, {255, 255, 255});
  double most_clips = 0.0;
  for (const auto* curve : {&losses, &errors}) {
    if (!curve->empty()) most_clips = std::max(most_clips, curve->back().clips);
  }
  const std::vector<CurvePoint> fine = thinned(losses, kArea.width);
  const Bounds of_losses = bounds_of(fine, most_clips);
  draw_axes(image, of_losses, 0, "training loss");
  draw_curve(image, fine, of_losses, 0, kPale, 1.0);
  draw_curve(image, thinned(losses, 60), of_losses, 0, kLine, 2.0);
  const Bounds of_errors = bounds_of(errors, most_clips);
  draw_axes(image, of_errors, kPanelHeight, "validation " + error_name);
  draw_curve(image, errors, of_errors, kPanelHeight, kLine, 2.0);
  return image;
}

}  // namespace earpoint

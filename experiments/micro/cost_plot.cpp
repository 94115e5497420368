#include "cost_plot.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/media/image_file.h>
#include <earpoint/plot/draw.h>

namespace earpoint {
namespace {

constexpr int kPanelWidth = 400;
constexpr int kPanelHeight = 340;
constexpr double kLeft = 62;
constexpr double kRight = 16;
constexpr double kTop = 44;
constexpr double kBottom = 52;
constexpr Color kInk{40, 40, 40};
constexpr Color kGrid{225, 225, 225};
constexpr Color kCurve{30, 90, 170};

// A logarithmic scale from a to b, drawn from `from` to `to`.
struct Scale {
  double a = 1.0;
  double b = 10.0;
  double from = 0.0;
  double to = 1.0;
  [[nodiscard]] double place(double value) const {
    return from + (to - from) * std::log(value / a) / std::log(b / a);
  }
};

// 1, 2 and 5 times powers of ten.
std::vector<double> ticks(double a, double b) {
  std::vector<double> result;
  for (int power = -6; power < 8; ++power) {
    for (const double first : {1.0, 2.0, 5.0}) {
      const double tick = first * std::pow(10.0, power);
      if (tick >= 0.999 * a && tick <= 1.001 * b) result.push_back(tick);
    }
  }
  return result;
}

void draw_panel(Image& image, double x0, const nlohmann::json& rows, const std::string& key,
                const std::string& title, double highest_s) {
  const double lowest = rows.front()[key].get<double>();
  const double highest = rows.back()[key].get<double>();
  const Scale x{0.8 * lowest, 1.25 * highest, x0 + kLeft, x0 + kPanelWidth - kRight};
  const Scale y{0.01, highest_s, kPanelHeight - kBottom, kTop};
  for (const double tick : ticks(y.a, y.b)) {
    draw_line(image, {x.from, y.place(tick)}, {x.to, y.place(tick)}, kGrid);
    draw_text(image, {x.from - 6, y.place(tick) + 4}, fmt::format("{:g}", tick),
              {.size = 12, .color = kInk, .align = TextAlign::right});
  }
  for (const double tick : ticks(x.a, x.b)) {
    draw_line(image, {x.place(tick), y.from}, {x.place(tick), y.to}, kGrid);
    draw_text(image, {x.place(tick), y.from + 18},
              tick >= 1000 ? fmt::format("{:g}k", tick / 1000) : fmt::format("{:g}", tick),
              {.size = 12, .color = kInk, .align = TextAlign::centre});
  }
  draw_line(image, {x.from, y.from}, {x.to, y.from}, kInk);
  draw_line(image, {x.from, y.from}, {x.from, y.to}, kInk);
  std::vector<Point> points;
  for (const nlohmann::json& row : rows) {
    points.push_back(
        {x.place(row[key].get<double>()), y.place(row["core_s_per_pair"].get<double>())});
  }
  draw_polyline(image, points, kCurve, 2.0);
  for (const Point& point : points) draw_polyline(image, {&point, 1}, kCurve, 7.0);
  draw_text(image, {(x.from + x.to) / 2, kPanelHeight - 12.0}, title,
            {.size = 13, .color = kInk, .align = TextAlign::centre});
}

}  // namespace

void draw_costs(const nlohmann::json& report, const std::string& path) {
  Image image = filled_image(3 * kPanelWidth, kPanelHeight, {255, 255, 255});
  double highest_s = 0.1;
  for (const char* part : {"over_triangles", "over_rays", "over_pairs"}) {
    for (const nlohmann::json& row : report[part]) {
      highest_s = std::max(highest_s, 1.3 * row["core_s_per_pair"].get<double>());
    }
  }
  draw_text(image, {14, 26}, "core-seconds per pair of source and listener",
            {.size = 14, .color = kInk, .is_bold = true});
  draw_panel(image, 0, report["over_triangles"], "triangles", "triangles (5,000 rays, 8 pairs)",
             highest_s);
  draw_panel(image, kPanelWidth, report["over_rays"], "rays", "rays (8 pairs)", highest_s);
  draw_panel(image, 2.0 * kPanelWidth, report["over_pairs"], "pairs", "pairs (5,000 rays)",
             highest_s);
  write_image(path, image);
}

}  // namespace earpoint

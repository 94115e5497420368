#include "axis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/plot/draw.h>
#include <earpoint/plot/plot.h>

namespace earpoint {
namespace {

// Pixels.
constexpr int kLeftMargin = 52;
constexpr int kRightMargin = 76;
constexpr int kTopMargin = 10;
constexpr int kTitleHeight = 28;
constexpr int kHeaderHeight = 26;
constexpr int kMapHeight = 200;
constexpr int kPanelGap = 10;
constexpr int kAxisHeight = 52;
constexpr int kScaleWidth = 12;

constexpr int kPanelHeight = kHeaderHeight + kMapHeight + kPanelGap;

/// Black through violet, red and orange to pale yellow, lightness growing evenly.
Color heat(double fraction) {
  constexpr std::array<Color, 8> kStops = {{{4, 4, 14},
                                            {38, 15, 79},
                                            {94, 22, 107},
                                            {150, 41, 97},
                                            {204, 67, 71},
                                            {240, 113, 34},
                                            {252, 176, 40},
                                            {252, 250, 176}}};
  const double place = std::clamp(fraction, 0.0, 1.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kStops.size() - 2);
  return mix(kStops[below], kStops[below + 1], place - static_cast<double>(below));
}

/// The largest level in a patch of the matrix: a narrow line stays visible when shrunk.
float largest_level(const SpectrogramPanel& panel, double frame_begin, double frame_end,
                    double bin_begin, double bin_end) {
  const auto range = [](double begin, double end, int count) {
    const int first = std::clamp(static_cast<int>(begin), 0, count - 1);
    return std::array{first, std::clamp(static_cast<int>(std::ceil(end)), first + 1, count)};
  };
  const auto frames = range(frame_begin, frame_end, panel.frames);
  const auto bins = range(bin_begin, bin_end, panel.bins);
  float largest = -std::numeric_limits<float>::infinity();
  for (int frame = frames[0]; frame < frames[1]; ++frame) {
    for (int bin = bins[0]; bin < bins[1]; ++bin) {
      largest = std::max(
          largest,
          panel.levels[static_cast<std::size_t>(frame) * static_cast<std::size_t>(panel.bins) +
                       static_cast<std::size_t>(bin)]);
    }
  }
  return largest;
}

void draw_map(Image& image, const SpectrogramPanel& panel, const Axis& time_s, int top,
              double top_db, double range_db) {
  const int left = static_cast<int>(time_s.from);
  const double columns_of_panel =
      (time_s.to - time_s.from) * panel.duration_s / (time_s.high - time_s.low);
  const double frames_per_column = panel.frames / columns_of_panel;
  const double bins_per_row = static_cast<double>(panel.bins) / kMapHeight;
  for (int x = 0; x < static_cast<int>(std::lround(columns_of_panel)); ++x) {
    for (int row = 0; row < kMapHeight; ++row) {
      const int from_bottom = kMapHeight - 1 - row;
      const float level =
          largest_level(panel, x * frames_per_column, (x + 1) * frames_per_column,
                        from_bottom * bins_per_row, (from_bottom + 1) * bins_per_row);
      const double fraction = std::isnan(level) ? 0.0 : 1.0 + (level - top_db) / range_db;
      const Color color = heat(fraction);
      image.at(left + x, top + row, 0) = color.red;
      image.at(left + x, top + row, 1) = color.green;
      image.at(left + x, top + row, 2) = color.blue;
    }
  }
}

void draw_frequency_axis(Image& image, const SpectrogramPanel& panel, int left, int top) {
  const Axis axis{0.0, panel.max_frequency_hz / 1000.0, 1.0 * top + kMapHeight, 1.0 * top};
  for (const Tick& tick : ticks(axis.low, axis.high, 6)) {
    const double y = axis.pixel(tick.value);
    fill_rect(image, {left - 5, std::min(static_cast<int>(y), top + kMapHeight - 1), 5, 1},
              kFaintInk);
    draw_text(image, {left - 9.0, y + 4.0}, tick.text,
              {.size = 11.0, .color = kFaintInk, .align = TextAlign::right});
  }
  draw_text(image, {left - 9.0, top - 10.0}, "kHz",
            {.size = 11.0, .color = kFaintInk, .align = TextAlign::right});
}

void draw_level_scale(Image& image, int left, int top, double top_db, double range_db) {
  for (int row = 0; row < kMapHeight; ++row) {
    fill_rect(image, {left, top + row, kScaleWidth, 1}, heat(1.0 - (row + 0.5) / kMapHeight));
  }
  const Axis axis{top_db - range_db, top_db, 1.0 * top + kMapHeight, 1.0 * top};
  for (const Tick& tick : ticks(axis.low, axis.high, 6)) {
    const double y = axis.pixel(tick.value);
    draw_text(image, {left + kScaleWidth + 6.0, y + 4.0}, tick.text,
              {.size = 11.0, .color = kFaintInk});
  }
  draw_text(image, {1.0 * left, top - 10.0}, "dB", {.size = 11.0, .color = kFaintInk});
}

}  // namespace

double top_level_db(std::span<const SpectrogramPanel> panels) {
  double largest = -std::numeric_limits<double>::infinity();
  for (const SpectrogramPanel& panel : panels) {
    for (const float level : panel.levels) {
      if (std::isfinite(level)) largest = std::max<double>(largest, level);
    }
  }
  constexpr double kStepDb = 5.0;
  return std::isfinite(largest) ? kStepDb * std::ceil(largest / kStepDb) : 0.0;
}

Image plot_spectrograms(std::span<const SpectrogramPanel> panels, const std::string& title,
                        double top_db, double range_db, int width) {
  EARPOINT_CHECK(!panels.empty() && width >= 400 && range_db > 0.0 && std::isfinite(top_db));
  double duration_s = 0.0;
  for (const SpectrogramPanel& panel : panels) {
    EARPOINT_CHECK(panel.frames > 0 && panel.bins > 0 && panel.duration_s > 0.0);
    EARPOINT_CHECK(panel.max_frequency_hz > 0.0);
    EARPOINT_CHECK(panel.levels.size() ==
                   static_cast<std::size_t>(panel.frames) * static_cast<std::size_t>(panel.bins));
    duration_s = std::max(duration_s, panel.duration_s);
  }
  const int panels_top = kTopMargin + (title.empty() ? 0 : kTitleHeight);
  const int panels_bottom = panels_top + kPanelHeight * static_cast<int>(panels.size()) - kPanelGap;

  Image image = filled_image(width, panels_bottom + kAxisHeight, kPaper);
  if (!title.empty()) draw_title(image, kLeftMargin, title);
  const Axis time_s{0.0, duration_s, 1.0 * kLeftMargin, 1.0 * width - kRightMargin};
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const int header = panels_top + kPanelHeight * static_cast<int>(i);
    const int top = header + kHeaderHeight;
    draw_text(image, {1.0 * kLeftMargin, top - 9.0}, panels[i].label,
              {.size = 14.0, .color = kInk});
    draw_map(image, panels[i], time_s, top, top_db, range_db);
    draw_frequency_axis(image, panels[i], kLeftMargin, top);
    draw_level_scale(image, width - kRightMargin + 14, top, top_db, range_db);
  }
  draw_time_axis(image, time_s, panels_bottom + 1);
  return image;
}

}  // namespace earpoint

#include "axis.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {

std::vector<Tick> ticks(double low, double high, int most) {
  EARPOINT_CHECK(high > low && most >= 2);
  const double least_step = (high - low) / (most - 1);
  const double power = std::pow(10.0, std::floor(std::log10(least_step)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= least_step * (1.0 - 1e-9)) step = factor * power;
  }
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  std::vector<Tick> result;
  // Counted in whole steps, so that no error adds up and 0 is 0.
  const auto last = std::llround(std::floor(high / step + 1e-9));
  for (auto i = std::llround(std::ceil(low / step - 1e-9)); i <= last; ++i) {
    const double value = static_cast<double>(i) * step;
    result.push_back({value, fmt::format("{:.{}f}", value, decimals)});
  }
  return result;
}

std::vector<Tick> time_ticks(const Axis& time_s) {
  constexpr double kPixelsPerTick = 70.0;
  const int most = std::max(2, static_cast<int>((time_s.to - time_s.from) / kPixelsPerTick));
  return ticks(time_s.low, time_s.high, most);
}

void draw_time_axis(Image& image, const Axis& time_s, int y) {
  for (const Tick& tick : time_ticks(time_s)) {
    const double x = time_s.pixel(tick.value);
    fill_rect(image, {static_cast<int>(x), y, 1, 5}, kFaintInk);
    draw_text(image, {x, y + 18.0}, tick.text,
              {.size = 12.0, .color = kFaintInk, .align = TextAlign::centre});
  }
  draw_text(image, {0.5 * (time_s.from + time_s.to), y + 36.0}, "time in s",
            {.size = 12.0, .color = kFaintInk, .align = TextAlign::centre});
}

void draw_title(Image& image, int x, const std::string& title) {
  draw_text(image, {1.0 * x, 29.0}, title, {.size = 18.0, .color = kInk, .is_bold = true});
}

}  // namespace earpoint

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

constexpr std::size_t kMostSpans = 8192;

constexpr std::array<Color, 2> kEarColors = {Color{31, 99, 181}, Color{213, 94, 0}};
constexpr std::array<const char*, 2> kEarNames = {"L", "R"};

// Pixels.
constexpr int kLeftMargin = 64;
constexpr int kRightMargin = 20;
constexpr int kTopMargin = 16;
constexpr int kTitleHeight = 28;
constexpr int kHeaderHeight = 26;  // a panel's label and levels
constexpr int kEarHeight = 62;
constexpr int kPanelGap = 10;
constexpr int kAxisHeight = 52;

constexpr int kPanelHeight = kHeaderHeight + 2 * kEarHeight + kPanelGap;

void merge(WaveformOutline::Span& into, const WaveformOutline::Span& other) {
  into.low = std::min(into.low, other.low);
  into.high = std::max(into.high, other.high);
  into.energy += other.energy;
}

WaveformOutline::Span span_of(std::span<const float> samples) {
  WaveformOutline::Span span{0.0F, 0.0F, 0.0};
  bool first = true;
  for (const float raw : samples) {
    const float sample = std::isfinite(raw) ? raw : 0.0F;
    span.low = first ? sample : std::min(span.low, sample);
    span.high = first ? sample : std::max(span.high, sample);
    span.energy += double{sample} * sample;
    first = false;
  }
  return span;
}

std::string level_text(double level_db) {
  return std::isfinite(level_db) ? fmt::format("{:.1f} dB", level_db) : "silent";
}

/// What falls into one column of pixels.
struct Column {
  WaveformOutline::Span span;
  std::int64_t spans = 0;
};

Column column_of(const WaveformOutline& sound, int ear, double begin_s, double end_s) {
  const auto spans = sound.spans(ear);
  const double spans_per_s =
      static_cast<double>(sound.sample_rate_hz()) / static_cast<double>(sound.samples_per_span());
  const auto count = static_cast<double>(spans.size());
  const auto begin = static_cast<std::size_t>(std::clamp(begin_s * spans_per_s, 0.0, count));
  // At least one span for every column before the end, however short the sound.
  const auto end = static_cast<std::size_t>(std::clamp(
      std::max(std::ceil(end_s * spans_per_s), static_cast<double>(begin) + 1), 0.0, count));
  Column column;
  for (std::size_t i = begin; i < end; ++i) {
    if (column.spans++ == 0) {
      column.span = spans[i];
    } else {
      merge(column.span, spans[i]);
    }
  }
  // Reach back to the column before, so that the line is drawn through.
  if (column.spans > 0 && begin > 0) {
    column.span.low = std::min(column.span.low, spans[begin - 1].high);
    column.span.high = std::max(column.span.high, spans[begin - 1].low);
  }
  return column;
}

/// One ear's waveform around the middle of a lane.
void draw_ear(Image& image, const WaveformOutline& sound, int ear, const Axis& time_s,
              const Axis& amplitude) {
  const Color color = kEarColors[static_cast<std::size_t>(ear)];
  const Color pale = mix(color, kPaper, 0.55);
  const double seconds_per_column = (time_s.high - time_s.low) / (time_s.to - time_s.from);
  for (int x = static_cast<int>(time_s.from); x < static_cast<int>(time_s.to); ++x) {
    const double begin_s = (x - time_s.from) * seconds_per_column;
    if (begin_s >= sound.duration_s()) return;
    const Column column = column_of(sound, ear, begin_s, begin_s + seconds_per_column);
    if (column.spans == 0) return;
    draw_column(image, x, amplitude.pixel(column.span.high), amplitude.pixel(column.span.low),
                pale);
    const auto samples = static_cast<double>(column.spans * sound.samples_per_span());
    const double rms = std::sqrt(column.span.energy / samples);
    draw_column(image, x, amplitude.pixel(std::min<double>(rms, column.span.high)),
                amplitude.pixel(std::max<double>(-rms, column.span.low)), color);
  }
}

void draw_lane(Image& image, const WaveformOutline& sound, int ear, const Axis& time_s, int top,
               double limit) {
  // A pixel of air keeps full scale off the frame.
  const Axis amplitude{-limit, limit, top + kEarHeight - 2.0, top + 2.0};
  const Color color = kEarColors[static_cast<std::size_t>(ear)];
  const double middle = amplitude.pixel(0.0);
  const int left = static_cast<int>(time_s.from);
  const int width = static_cast<int>(time_s.to - time_s.from);
  for (const Tick& tick : time_ticks(time_s)) {
    fill_rect(image, {static_cast<int>(time_s.pixel(tick.value)), top, 1, kEarHeight}, kGrid);
  }
  fill_rect(image, {left, static_cast<int>(middle), width, 1}, kGrid);
  if (ear == 1) fill_rect(image, {left, top, width, 1}, mix(kGrid, kFaintInk, 0.3));
  draw_ear(image, sound, ear, time_s, amplitude);
  draw_text(image, {time_s.from - 40.0, middle + 5.0}, kEarNames[static_cast<std::size_t>(ear)],
            {.size = 15.0, .color = color, .is_bold = true, .align = TextAlign::right});
  for (const double value : {limit, 0.0}) {
    draw_text(image, {time_s.from - 7.0, amplitude.pixel(value) + (value > 0.0 ? 8.0 : 4.0)},
              fmt::format("{:g}", value),
              {.size = 10.0, .color = kFaintInk, .align = TextAlign::right});
  }
}

void draw_panel(Image& image, const WaveformPanel& panel, const Axis& time_s, int top,
                double limit) {
  const double baseline = top + kHeaderHeight - 9.0;
  draw_text(image, {time_s.from, baseline}, panel.label, {.size = 14.0, .color = kInk});
  double x = time_s.to;
  for (const int ear : {1, 0}) {
    const TextStyle style{.size = 13.0,
                          .color = kEarColors[static_cast<std::size_t>(ear)],
                          .align = TextAlign::right};
    const std::string text = fmt::format("{} {}", kEarNames[static_cast<std::size_t>(ear)],
                                         level_text(panel.sound.level_db(ear)));
    draw_text(image, {x, baseline}, text, style);
    x -= text_width(text, style) + 18.0;
  }
  const int lanes_top = top + kHeaderHeight;
  draw_lane(image, panel.sound, 0, time_s, lanes_top, limit);
  draw_lane(image, panel.sound, 1, time_s, lanes_top + kEarHeight, limit);
  outline_rect(image,
               {static_cast<int>(time_s.from) - 1, lanes_top - 1,
                static_cast<int>(time_s.to - time_s.from) + 2, 2 * kEarHeight + 2},
               mix(kFaintInk, kPaper, 0.5));
}

/// The amplitude that a lane's edge stands for: a round number, little above the peak.
double common_limit(std::span<const WaveformPanel> panels) {
  double peak = 0.0;
  for (const WaveformPanel& panel : panels) peak = std::max(peak, panel.sound.peak());
  if (peak <= 0.0) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(peak)));
  for (const double factor : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (factor * power >= peak * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

}  // namespace

WaveformOutline::WaveformOutline(int sample_rate_hz) : sample_rate_hz_(sample_rate_hz) {
  EARPOINT_CHECK(sample_rate_hz > 0);
}

WaveformOutline::WaveformOutline(const Waveform& sound) : WaveformOutline(sound.sample_rate_hz()) {
  add(sound);
}

void WaveformOutline::add(const Waveform& block) {
  EARPOINT_CHECK(block.channels() == 2 && block.sample_rate_hz() == sample_rate_hz_);
  for (std::ptrdiff_t start = 0; start < block.samples();) {
    const bool begins_span = samples_ % samples_per_span_ == 0;
    if (begins_span && spans_[0].size() == kMostSpans) halve_resolution();
    const std::ptrdiff_t count = std::min<std::ptrdiff_t>(
        samples_per_span_ - samples_ % samples_per_span_, block.samples() - start);
    for (std::size_t ear = 0; ear < 2; ++ear) {
      const Span span =
          span_of(block.channel(static_cast<int>(ear))
                      .subspan(static_cast<std::size_t>(start), static_cast<std::size_t>(count)));
      if (samples_ % samples_per_span_ == 0) {
        spans_[ear].push_back(span);
      } else {
        merge(spans_[ear].back(), span);
      }
    }
    samples_ += count;
    start += count;
  }
}

void WaveformOutline::halve_resolution() {
  for (auto& spans : spans_) {
    for (std::size_t i = 0; i < spans.size() / 2; ++i) {
      spans[i] = spans[2 * i];
      merge(spans[i], spans[2 * i + 1]);
    }
    spans.resize(spans.size() / 2);
  }
  samples_per_span_ *= 2;
}

double WaveformOutline::duration_s() const {
  return static_cast<double>(samples_) / sample_rate_hz_;
}

std::span<const WaveformOutline::Span> WaveformOutline::spans(int ear) const {
  EARPOINT_CHECK(ear == 0 || ear == 1);
  return spans_[static_cast<std::size_t>(ear)];
}

double WaveformOutline::peak() const {
  float largest = 0.0F;
  for (const auto& spans : spans_) {
    for (const Span& span : spans) largest = std::max({largest, span.high, -span.low});
  }
  return largest;
}

double WaveformOutline::level_db(int ear) const {
  double energy = 0.0;
  for (const Span& span : spans(ear)) energy += span.energy;
  if (energy <= 0.0) return -std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(energy / static_cast<double>(samples_));
}

Image plot_waveforms(std::span<const WaveformPanel> panels, const std::string& title, int width) {
  EARPOINT_CHECK(!panels.empty() && width >= 400);
  double duration_s = 0.0;
  for (const WaveformPanel& panel : panels) {
    duration_s = std::max(duration_s, panel.sound.duration_s());
  }
  if (duration_s <= 0.0) duration_s = 1.0;  // nothing to show, but still a plot
  const int panels_top = kTopMargin + (title.empty() ? 0 : kTitleHeight);
  const int panels_bottom = panels_top + kPanelHeight * static_cast<int>(panels.size()) - kPanelGap;

  Image image = filled_image(width, panels_bottom + kAxisHeight, kPaper);
  if (!title.empty()) draw_title(image, kLeftMargin, title);
  const Axis time_s{0.0, duration_s, 1.0 * kLeftMargin, 1.0 * width - kRightMargin};
  const double limit = common_limit(panels);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    draw_panel(image, panels[i], time_s, panels_top + kPanelHeight * static_cast<int>(i), limit);
  }
  draw_time_axis(image, time_s, panels_bottom + 1);
  return image;
}

}  // namespace earpoint

#include <earpoint/evaluate/view_figure.h>

#include "report_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/evaluate/report_html.h>
#include <earpoint/media/image_file.h>
#include <earpoint/plot/plot.h>

namespace earpoint {
namespace {

constexpr double kMargin = 14.0;
constexpr double kColumn = 236.0;
constexpr double kBetweenColumns = 18.0;
constexpr double kBetweenRows = 22.0;
constexpr double kBetweenEars = 6.0;
constexpr double kTitle = 22.0;
constexpr double kCaptionLine = 15.0;
constexpr double kBelowCaption = 8.0;
constexpr double kLegend = 20.0;
constexpr const char* kLegendText =
    "Left ear blue, right ear orange: extremes pale, root mean square solid; levels in dB re full "
    "scale";
constexpr double kLabel = 16.0;
constexpr double kWave = 50.0;
constexpr double kBetweenSounds = 8.0;
constexpr double kLeastHalf = 0.5;  // of a waveform's height where it is silent, pixels
constexpr std::array<const char*, 2> kEarColors{"#2563a8", "#d9731a"};
constexpr const char* kVoiceColor = "#3f4a59";
constexpr const char* kSpeaksColor = "#ffc400";
constexpr double kTurnedLeastDegrees = 0.5;
constexpr double kMovedLeast_m = 0.05;

std::string text(double x, double y, std::string_view what, std::string_view attributes = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\"{}{}>{}</text>\n", x, y,
                     attributes.empty() ? "" : " ", attributes, escaped(what));
}

/// One ear over the columns of a plot, in units of half its height: minimum, maximum, root mean
/// square.
struct Envelope {
  std::vector<double> low, high, rms;
};

Envelope envelope_of(const WaveformOutline& sound, int ear, std::size_t columns) {
  const std::span<const WaveformOutline::Span> spans = sound.spans(ear);
  Envelope envelope;
  for (std::size_t column = 0; column < columns; ++column) {
    const std::size_t begin = column * spans.size() / columns;
    const std::size_t end = std::max(begin + 1, (column + 1) * spans.size() / columns);
    double low = 0.0;
    double high = 0.0;
    double energy = 0.0;
    for (std::size_t i = begin; i < std::min(end, spans.size()); ++i) {
      low = std::min(low, double{spans[i].low});
      high = std::max(high, double{spans[i].high});
      energy += spans[i].energy;
    }
    const double samples = static_cast<double>(sound.samples_per_span()) * double(end - begin);
    envelope.low.push_back(low);
    envelope.high.push_back(high);
    envelope.rms.push_back(std::sqrt(energy / samples));
  }
  return envelope;
}

/// The area between two curves, as a closed path with one point per column.
std::string band(const std::vector<double>& upper, const std::vector<double>& lower, double x,
                 double middle_y, double pixels_per_unit) {
  std::string path = "M";
  for (std::size_t i = 0; i < upper.size(); ++i) {
    path += fmt::format("{:.1f} {:.1f} ", x + double(i),
                        middle_y - std::max(upper[i] * pixels_per_unit, kLeastHalf));
  }
  for (std::size_t i = lower.size(); i-- > 0;) {
    path += fmt::format("{:.1f} {:.1f} ", x + double(i),
                        middle_y - std::min(lower[i] * pixels_per_unit, -kLeastHalf));
  }
  return path + "Z";
}

/// One ear of a sound.
struct EarPlot {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  std::string_view color;
};

std::string ear_svg(const WaveformOutline& sound, int ear, const EarPlot& plot, double peak) {
  const double middle = plot.y + kWave / 2.0;
  const double scale = (kWave / 2.0 - 2.0) / peak;
  const Envelope envelope = envelope_of(sound, ear, static_cast<std::size_t>(plot.width));
  std::vector<double> below = envelope.rms;
  for (double& x : below) x = -x;
  const double level_db = sound.level_db(ear);
  const std::string level =
      std::isfinite(level_db) ? fmt::format("{:.0f} dB", std::round(level_db) + 0.0) : "silent";
  return fmt::format(
             "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"3\" "
             "fill=\"#f3f5f8\"/>\n<path d=\"{}\" fill=\"{}\" opacity=\"0.4\"/>\n"
             "<path d=\"{}\" fill=\"{}\"/>\n",
             plot.x, plot.y, plot.width, kWave,
             band(envelope.high, envelope.low, plot.x, middle, scale), plot.color,
             band(envelope.rms, below, plot.x, middle, scale), plot.color) +
         text(plot.x + plot.width, plot.y - 5.0, level,
              "text-anchor=\"end\" font-size=\"9.5\" fill=\"#667085\"");
}

/// WaveformOutline has two ears: a single channel is shown as the left one.
WaveformOutline outline_of(const Waveform& sound) {
  if (sound.channels() == 2) return WaveformOutline(sound);
  Waveform both(2, sound.samples(), sound.sample_rate_hz());
  for (int ear = 0; ear < 2; ++ear) std::ranges::copy(sound.channel(0), both.channel(ear).begin());
  return WaveformOutline(both);
}

std::string sound_svg(const FigureSound& sound, double x, double y, double peak) {
  const WaveformOutline outline = outline_of(sound.sound);
  std::string svg = text(x, y + 11.0, sound.label, "font-size=\"11.5\"");
  y += kLabel;
  if (sound.sound.channels() != 2) {
    return svg + ear_svg(outline, 0, {x, y, kColumn, kVoiceColor}, peak);
  }
  const double width = (kColumn - kBetweenEars) / 2.0;
  svg += ear_svg(outline, 0, {x, y, width, kEarColors[0]}, peak);
  return svg + ear_svg(outline, 1, {x + width + kBetweenEars, y, width, kEarColors[1]}, peak);
}

double picture_height(const FigureView& view) {
  if (view.picture.empty()) return 0.0;
  return std::min(kColumn, kColumn * view.picture.height() / view.picture.width());
}

std::string box_svg(const FigureBox& person, double x, double y, double width, double height) {
  const Box& box = person.box;
  return fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" "
      "stroke=\"{}\" stroke-width=\"{}\"/>\n",
      x + box.x_min * width, y + box.y_min * height, (box.x_max - box.x_min) * width,
      (box.y_max - box.y_min) * height, person.speaks ? kSpeaksColor : "#ffffff",
      person.speaks ? 2.5 : 1.2);
}

/// The picture with its boxes in the middle of its column, or the map.
std::string scene_svg(const FigureView& view, double x, double y, double height) {
  if (view.picture.empty()) {
    if (!view.source_from_target) return "";
    const double size = std::min(kColumn, height);
    return fmt::format(
        "<svg x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\">{}</svg>\n",
        x + (kColumn - size) / 2.0, y, size, size,
        map_svg(*view.source_from_target, view.speaker_m));
  }
  const double tall = picture_height(view);
  const double wide = tall * view.picture.width() / view.picture.height();
  const double left = x + (kColumn - wide) / 2.0;
  const double top = y + (height - tall) / 2.0;
  std::string svg = fmt::format(
      "<image x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" "
      "href=\"data:image/jpeg;base64,{}\"/>\n",
      left, top, wide, tall, base64(encode_jpeg(view.picture)));
  for (const FigureBox& person : view.boxes) svg += box_svg(person, left, top, wide, tall);
  return svg;
}

double peak_of(const FigureView& view) {
  double peak = 1e-6;
  for (const FigureSound& sound : view.sounds) {
    for (const float x : sound.sound.planar()) peak = std::max(peak, std::abs(double{x}));
  }
  return peak;
}

/// What the columns of a row have in common.
struct RowFrame {
  double scene_height = 0.0;
  double caption_height = 0.0;
  double height = 0.0;
  double peak = 1e-6;
};

RowFrame frame_of(const FigureRow& row) {
  RowFrame frame;
  std::size_t sounds = 0;
  for (const FigureView& view : row.views) {
    frame.scene_height = std::max(frame.scene_height, picture_height(view));
    if (view.picture.empty() && view.source_from_target) frame.scene_height = kColumn;
    frame.caption_height =
        std::max(frame.caption_height, kCaptionLine * double(view.caption.size()));
    sounds = std::max(sounds, view.sounds.size());
    if (!view.has_own_scale) frame.peak = std::max(frame.peak, peak_of(view));
  }
  frame.caption_height += kBelowCaption;
  frame.height = (row.title.empty() ? 0.0 : kTitle) + kTitle + frame.scene_height +
                 frame.caption_height + double(sounds) * (kLabel + kWave + kBetweenSounds);
  return frame;
}

std::string row_svg(const FigureRow& row, const RowFrame& frame, double y) {
  std::string svg;
  if (!row.title.empty()) {
    svg += text(kMargin, y + 13.0, row.title, "fill=\"#667085\" font-size=\"12\"");
    y += kTitle;
  }
  double x = kMargin;
  for (const FigureView& view : row.views) {
    svg += text(x, y + 14.0, view.title, "font-weight=\"600\" font-size=\"13.5\"");
    svg += scene_svg(view, x, y + kTitle, frame.scene_height);
    double at = y + kTitle + frame.scene_height;
    for (std::size_t line = 0; line < view.caption.size(); ++line) {
      svg += text(x, at + kCaptionLine * (double(line) + 0.9), view.caption[line],
                  "fill=\"#667085\" font-size=\"11\"");
    }
    at += frame.caption_height;
    const double peak = view.has_own_scale ? peak_of(view) : frame.peak;
    for (const FigureSound& sound : view.sounds) {
      svg += sound_svg(sound, x, at, peak);
      at += kLabel + kWave + kBetweenSounds;
    }
    x += kColumn + kBetweenColumns;
  }
  return svg;
}

}  // namespace

std::vector<std::string> words_of(const Pose& source_from_target) {
  const Vector3& at = source_from_target.position_m;
  const double yaw_deg =
      degrees_from_radians(euler_from_quaternion(source_from_target.orientation).yaw_rad);
  std::string place;
  const auto move = [&](double metres, const char* more, const char* less) {
    if (std::abs(metres) < kMovedLeast_m) return;
    place += fmt::format("{}{:.1f} m {}", place.empty() ? "" : ", ", std::abs(metres),
                         metres > 0.0 ? more : less);
  };
  move(at.x, "ahead", "behind");
  move(at.y, "left", "right");
  move(at.z, "up", "down");
  std::vector<std::string> words{place.empty() ? "the same place" : place};
  if (std::abs(yaw_deg) >= kTurnedLeastDegrees) {
    words.push_back(
        fmt::format("turned {:.0f}° {}", std::abs(yaw_deg), yaw_deg > 0.0 ? "left" : "right"));
  }
  return words;
}

std::string view_figure_svg(std::span<const FigureRow> rows) {
  EARPOINT_CHECK(!rows.empty());
  double y = kMargin;
  std::size_t columns = 0;
  std::string body;
  for (const FigureRow& row : rows) {
    EARPOINT_CHECK(!row.views.empty());
    const RowFrame frame = frame_of(row);
    body += row_svg(row, frame, y);
    y += frame.height + kBetweenRows;
    columns = std::max(columns, row.views.size());
  }
  const double width =
      2.0 * kMargin + double(columns) * (kColumn + kBetweenColumns) - kBetweenColumns;
  const double height = y - kBetweenRows + kLegend + kMargin;
  body += text(kMargin, height - kMargin, kLegendText, "fill=\"#667085\" font-size=\"11\"");
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"0 0 {0:.0f} {1:.0f}\" font-family=\"system-ui, 'Liberation Sans', sans-serif\" "
      "fill=\"#1d2430\">\n<rect width=\"{0:.0f}\" height=\"{1:.0f}\" fill=\"#ffffff\"/>\n{2}"
      "</svg>\n",
      width, height, body);
}

}  // namespace earpoint

#include "report_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include <earpoint/evaluate/bootstrap.h>
#include <earpoint/evaluate/evaluation_table.h>
#include <earpoint/evaluate/report_html.h>

namespace earpoint {
namespace {

constexpr double kMapSize = 256.0;
constexpr double kMapMargin = 34.0;

/// From metres in the source's frame to the page: x up, y to the left.
class MapScale {
 public:
  explicit MapScale(std::span<const Vector3> points) {
    double left = 0.0;
    double right = 0.0;
    double bottom = 0.0;
    double top = 0.0;
    for (const Vector3& p : points) {
      left = std::min(left, -p.y);
      right = std::max(right, -p.y);
      bottom = std::min(bottom, p.x);
      top = std::max(top, p.x);
    }
    const double extent = std::max({right - left, top - bottom, 1.0});
    pixels_per_metre_ = (kMapSize - 2.0 * kMapMargin) / extent;
    middle_x_ = (left + right) / 2.0;
    middle_y_ = (bottom + top) / 2.0;
  }
  [[nodiscard]] double x(const Vector3& p) const {
    return kMapSize / 2.0 + (-p.y - middle_x_) * pixels_per_metre_;
  }
  [[nodiscard]] double y(const Vector3& p) const {
    return kMapSize / 2.0 - (p.x - middle_y_) * pixels_per_metre_;
  }
  [[nodiscard]] double pixels_per_metre() const { return pixels_per_metre_; }

 private:
  double pixels_per_metre_ = 1.0;
  double middle_x_ = 0.0;
  double middle_y_ = 0.0;
};

/// A head from above: a disc with ears and a nose.
std::string head(double x, double y, double yaw_rad, std::string_view color,
                 std::string_view label) {
  // On the page 0 looks up and angles grow clockwise.
  return fmt::format(
      "<g transform=\"translate({:.1f} {:.1f}) rotate({:.1f})\">"
      "<path d=\"M-5 -8 L0 -16 L5 -8 Z\" fill=\"{}\"/>"
      "<circle cx=\"-9\" r=\"3\" fill=\"{}\"/><circle cx=\"9\" r=\"3\" fill=\"{}\"/>"
      "<circle r=\"9\" fill=\"{}\" stroke=\"#fff\" stroke-width=\"1.5\"/></g>"
      "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>",
      x, y, -degrees_from_radians(yaw_rad), color, color, color, color, x, y + 26.0, label);
}

double horizontal(const Vector3& v) { return std::hypot(v.x, v.y); }

constexpr double kWidth = 360.0;
constexpr double kHeight = 230.0;
constexpr double kLeft = 52.0;
constexpr double kRight = 12.0;
constexpr double kTop = 26.0;
constexpr double kBottom = 40.0;
constexpr std::size_t kBins = 5;

/// Clips sorted along the axis, in bins of equal size.
std::vector<std::vector<std::size_t>> bins_of(const EvaluationResult& result,
                                              const CurveAxis& axis) {
  std::vector<std::size_t> order(result.clips.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {},
                           [&](std::size_t clip) { return axis.value(result.clips[clip]); });
  const std::size_t count = std::min(kBins, order.size());
  std::vector<std::vector<std::size_t>> bins(count);
  for (std::size_t i = 0; i < order.size(); ++i) bins[i * count / order.size()].push_back(order[i]);
  return bins;
}

struct CurvePoint {
  double x = 0.0;
  Estimate y;
};

/// @return [method][bin]
std::vector<std::vector<CurvePoint>> curves_of(const EvaluationResult& result, Metric metric,
                                               const CurveAxis& axis) {
  const std::vector<int> all_clusters = interval_clusters(result);
  std::vector<std::vector<CurvePoint>> curves(result.methods.size());
  for (const std::vector<std::size_t>& bin : bins_of(result, axis)) {
    std::vector<int> clusters;
    clusters.reserve(bin.size());
    double x = 0.0;
    for (const std::size_t clip : bin) {
      clusters.push_back(all_clusters[clip]);
      x += axis.value(result.clips[clip]) / static_cast<double>(bin.size());
    }
    const ClusterBootstrap bootstrap(clusters, {.replicates = 1000});
    for (std::size_t m = 0; m < curves.size(); ++m) {
      std::vector<std::optional<double>> values;
      values.reserve(bin.size());
      for (const std::size_t clip : bin) values.push_back(result.clips[clip].honest[m][metric]);
      if (const auto mean = bootstrap.mean(values)) curves[m].push_back({x, *mean});
    }
  }
  return curves;
}

/// 1, 2 or 5 times a power of ten: about four steps up to `most`.
double tick_step(double most) {
  const double rough = most / 4.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10.0 * power;
}

/// The plot's frame, and the positions of values in it; both axes start at zero.
struct CurveScale {
  double x_most = 1.0;
  double y_most = 1.0;
  [[nodiscard]] double x(double value) const {
    return kLeft + value / x_most * (kWidth - kLeft - kRight);
  }
  [[nodiscard]] double y(double value) const {
    return kHeight - kBottom - value / y_most * (kHeight - kTop - kBottom);
  }
};

std::string frame(const CurveScale& scale, Metric metric, const CurveAxis& axis) {
  std::string svg;
  for (double v = 0.0; v <= scale.y_most * 1.0001; v += tick_step(scale.y_most)) {
    svg += fmt::format(
        "<line x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#e4e7ec\"/>"
        "<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:.3g}</text>",
        kLeft, kWidth - kRight, scale.y(v), scale.y(v), kLeft - 6, scale.y(v) + 4, v);
  }
  for (double v = 0.0; v <= scale.x_most * 1.0001; v += tick_step(scale.x_most)) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:.3g}</text>",
                       scale.x(v), kHeight - kBottom + 16, v);
  }
  const MetricName& name = name_of(metric);
  return svg + fmt::format(
                   "<text x=\"{}\" y=\"14\" font-weight=\"600\" fill=\"#1d2430\">{}{}{}</text>"
                   "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                   kLeft, name.heading, name.unit.empty() ? "" : ", ", name.unit,
                   (kLeft + kWidth - kRight) / 2, kHeight - 6, axis.label);
}

std::string curve(const CurveScale& scale, const std::vector<CurvePoint>& points,
                  const std::string& color, bool is_oracle, double shift) {
  std::string path;
  std::string marks;
  for (const CurvePoint& point : points) {
    const double x = scale.x(point.x) + shift;
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : " L", x, scale.y(point.y.value));
    if (point.y.range) {
      marks += fmt::format(
          "<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" "
          "opacity=\"0.55\"/>",
          x, x, scale.y(point.y.range->low), scale.y(point.y.range->high), color);
    }
    marks += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.6\" fill=\"{}\"/>", x,
                         scale.y(point.y.value), color);
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\"{}/>{}", path,
                     color, is_oracle ? " stroke-dasharray=\"4 3\"" : "", marks);
}

}  // namespace

std::string map_svg(const Pose& source_from_target, const std::optional<Vector3>& speaker_m) {
  const Vector3& target_m = source_from_target.position_m;
  const std::array<Vector3, 2> points{target_m, speaker_m.value_or(target_m)};
  const MapScale scale(points);
  const Vector3 source_m;
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {0} {0}\" role=\"img\" aria-label=\"map from above\" "
      "font-family=\"sans-serif\" font-size=\"12\" fill=\"#1d2430\">"
      "<rect width=\"{0}\" height=\"{0}\" fill=\"#f3f5f8\"/>",
      kMapSize);
  const int rings =
      static_cast<int>(std::ceil(std::max(horizontal(target_m), horizontal(points[1])) + 1.0));
  for (int ring = 1; ring <= rings; ++ring) {
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"none\" stroke=\"#dde2e9\"/>",
        scale.x(source_m), scale.y(source_m), ring * scale.pixels_per_metre());
  }
  if (speaker_m) {
    svg += fmt::format(
        "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"7\" fill=\"#e08e2b\" stroke=\"#fff\" "
        "stroke-width=\"1.5\"/><text x=\"{0:.1f}\" y=\"{2:.1f}\" text-anchor=\"middle\">speaker"
        "</text>",
        scale.x(*speaker_m), scale.y(*speaker_m), scale.y(*speaker_m) - 13.0);
  }
  svg += head(scale.x(source_m), scale.y(source_m), 0.0, "#7a828e", "source");
  svg += head(scale.x(target_m), scale.y(target_m),
              euler_from_quaternion(source_from_target.orientation).yaw_rad, "#2563a8", "target");
  return svg + "</svg>";
}

std::span<const CurveAxis> curve_axes() {
  static const std::array<CurveAxis, 3> axes = {{
      {"from source to target, m",
       [](const ClipResult& clip) { return norm(clip.source_from_target.position_m); }},
      {"turn from source to target, degrees",
       [](const ClipResult& clip) {
         return degrees_from_radians(
             std::abs(euler_from_quaternion(clip.source_from_target.orientation).yaw_rad));
       }},
      {"from target to speaker, m",
       [](const ClipResult& clip) {
         return norm(*clip.speaker_m - clip.source_from_target.position_m);
       },
       true},
  }};
  return axes;
}

std::string curve_svg(const EvaluationResult& result, Metric metric, const CurveAxis& axis) {
  const auto curves = curves_of(result, metric, axis);
  CurveScale scale{.x_most = 0.0, .y_most = 0.0};
  for (const auto& points : curves) {
    for (const CurvePoint& point : points) {
      scale.x_most = std::max(scale.x_most, point.x * 1.08);
      scale.y_most =
          std::max(scale.y_most, 1.04 * (point.y.range ? point.y.range->high : point.y.value));
    }
  }
  // All clips at one place, or all errors zero: any scale will do.
  if (scale.x_most <= 0.0) scale.x_most = 1.0;
  if (scale.y_most <= 0.0) scale.y_most = 1.0;
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{} over {}\" "
      "font-family=\"sans-serif\" font-size=\"11\" fill=\"#667085\">",
      kWidth, kHeight, name_of(metric).heading, axis.label);
  svg += frame(scale, metric, axis);
  for (std::size_t m = 0; m < curves.size(); ++m) {
    // Moved a little sideways, so that intervals do not hide each other.
    const double shift =
        2.2 * (static_cast<double>(m) - static_cast<double>(curves.size() - 1) / 2);
    svg += curve(scale, curves[m], color_of(m, result.methods[m].name), result.methods[m].is_oracle,
                 shift);
  }
  return svg + "</svg>";
}

}  // namespace earpoint

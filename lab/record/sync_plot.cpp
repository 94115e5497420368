#include <earpoint/record/sync_plot.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/plot/draw.h>

namespace earpoint {
namespace {

constexpr int kWidth = 1200;
constexpr int kLeft = 250;
constexpr int kRight = 60;
constexpr int kTop = 40;
constexpr int kStrip = 46;
constexpr int kBottom = 40;
constexpr double kSpanMs = 0.6;  ///< what the fit keeps

constexpr Color kWhite{255, 255, 255};
constexpr Color kGrey{120, 120, 120};
constexpr Color kPale{225, 225, 225};
constexpr Color kBlue{31, 98, 171};
constexpr Color kOrange{215, 110, 20};

class SyncPlot {
 public:
  SyncPlot(const SyncResult& result, double duration_s)
      : result_(result),
        duration_s_(duration_s),
        image_(filled_image(
            kWidth, kTop + kStrip * static_cast<int>(result.devices.size()) + kBottom, kWhite)) {}

  Image draw() {
    draw_text(image_, {10.0, 24.0},
              fmt::format("Clocks against camera {}: residuals of arrival times, +-{:.1f} ms",
                          result_.devices.front().clock.name, kSpanMs),
              {.size = 16.0, .is_bold = true});
    for (std::size_t d = 0; d < result_.devices.size(); ++d) strip(d);
    for (const SyncResidual& residual : result_.residuals) {
      const double y =
          middle(residual.device) - 1e3 * residual.residual_s / kSpanMs * (0.5 * kStrip - 4.0);
      fill_rect(image_, {column(residual.time_s) - 1, static_cast<int>(y) - 1, 2, 2}, kBlue, 0.5);
    }
    for (const LocatedVoice& voice : result_.voices) {
      fill_rect(image_,
                {column(voice.time_s) - 1, static_cast<int>(middle(voice.device)) - 8, 3, 16},
                kOrange, 0.7);
    }
    axis();
    return std::move(image_);
  }

 private:
  [[nodiscard]] int column(double time_s) const {
    return kLeft + static_cast<int>(std::lround(time_s / duration_s_ * (kWidth - kLeft - kRight)));
  }
  [[nodiscard]] static double middle(std::size_t device) {
    return kTop + kStrip * (static_cast<double>(device) + 0.5);
  }

  void strip(std::size_t d) {
    const SyncedDevice& device = result_.devices[d];
    const double y = middle(d);
    draw_line(image_, {kLeft, y}, {kWidth - kRight, y}, kPale);
    draw_text(image_, {10.0, y - 3.0},
              fmt::format("{} {}", device.is_camera ? "camera" : "near", device.clock.name),
              {.size = 13.0, .is_bold = true});
    draw_text(image_, {10.0, y + 13.0},
              fmt::format("{:+.4f} s  {:+.2f} ppm  {}", device.clock.offset_s,
                          device.clock.drift_ppm, name_of(device.method)),
              {.size = 12.0, .color = kGrey});
  }

  void axis() {
    // Round steps, at most twelve.
    double step_s = 1.0;
    for (const double candidate : {1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0}) {
      step_s = candidate;
      if (duration_s_ / step_s <= 12.0) break;
    }
    const double y = image_.height() - kBottom + 4.0;
    draw_line(image_, {kLeft, y}, {kWidth - kRight, y}, kGrey);
    for (double time_s = 0.0; time_s <= duration_s_; time_s += step_s) {
      const double x = column(time_s);
      draw_line(image_, {x, y}, {x, y + 5.0}, kGrey);
      draw_text(image_, {x, y + 20.0}, fmt::format("{:g} s", time_s),
                {.size = 12.0, .color = kGrey, .align = TextAlign::centre});
    }
  }

  const SyncResult& result_;
  double duration_s_;
  Image image_;
};

}  // namespace

Image plot_sync(const SyncResult& result, double duration_s) {
  EARPOINT_CHECK(!result.devices.empty() && duration_s > 0.0);
  return SyncPlot(result, duration_s).draw();
}

}  // namespace earpoint

#include "report_sounds.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/stft.h>
#include <earpoint/evaluate/report_html.h>
#include <earpoint/plot/draw.h>
#include <earpoint/plot/plot.h>

namespace earpoint {
namespace {

constexpr int kPlotWidth = 480;
constexpr Color kBoxColor{255, 196, 0};

}  // namespace

std::string waveform_plot(std::span<const NamedSound> sounds) {
  std::vector<WaveformPanel> panels;
  panels.reserve(sounds.size());
  for (const NamedSound& sound : sounds) {
    panels.push_back({sound.name, WaveformOutline(sound.wave)});
  }
  return img_tag(plot_waveforms(panels, "left ear blue, right ear orange", kPlotWidth), "waveforms",
                 "plot");
}

std::string spectrogram_plot(std::span<const NamedSound> sounds, int ear) {
  Stft stft;
  std::vector<std::vector<float>> levels;
  std::vector<SpectrogramPanel> panels;
  for (const NamedSound& sound : sounds) {
    const Spectrogram spectrum = stft.forward(sound.wave.channel(ear));
    std::vector<float>& db = levels.emplace_back();
    for (const std::complex<float>& value : spectrum.values) {
      db.push_back(10.0F * std::log10(std::norm(value)));
    }
    panels.push_back({.label = sound.name,
                      .levels = {},
                      .frames = spectrum.frames,
                      .bins = spectrum.bins,
                      .duration_s = sound.wave.duration_s(),
                      .max_frequency_hz = sound.wave.sample_rate_hz() / 2.0});
  }
  for (std::size_t i = 0; i < panels.size(); ++i) panels[i].levels = levels[i];
  const char* title = ear == 0 ? "left ear" : "right ear";
  return img_tag(plot_spectrograms(panels, title, top_level_db(panels), 70.0, kPlotWidth),
                 fmt::format("spectrograms, {}", title), "plot");
}

Image cut_out(const Image& picture, const Box& box) {
  const double side = std::max((box.x_max - box.x_min) * picture.width(),
                               (box.y_max - box.y_min) * picture.height());
  const int size = std::clamp(static_cast<int>(std::lround(side)), 1,
                              std::min(picture.width(), picture.height()));
  const auto begin = [&](double low, double high, int pixels) {
    const auto middle = static_cast<int>(std::lround(0.5 * (low + high) * pixels));
    return std::clamp(middle - size / 2, 0, pixels - size);
  };
  Image part(size, size, picture.channels());
  paste(part, picture, -begin(box.x_min, box.x_max, picture.width()),
        -begin(box.y_min, box.y_max, picture.height()));
  return part;
}

Image boxed(Image picture, const std::optional<Box>& speaker_box) {
  if (!speaker_box) return picture;
  const Box& box = *speaker_box;
  const auto column = [&](double x) { return static_cast<int>(std::lround(x * picture.width())); };
  const auto row = [&](double y) { return static_cast<int>(std::lround(y * picture.height())); };
  const PixelRect rect{column(box.x_min), row(box.y_min), column(box.x_max) - column(box.x_min),
                       row(box.y_max) - row(box.y_min)};
  outline_rect(picture, rect, kBoxColor);
  outline_rect(picture, {rect.x + 1, rect.y + 1, rect.width - 2, rect.height - 2}, kBoxColor);
  return picture;
}

}  // namespace earpoint

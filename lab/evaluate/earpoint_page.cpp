#include "earpoint_map.h"
#include "report_figures.h"
#include "report_sounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/earpoint_comparison.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/evaluate/report_html.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::array<Metric, 3> kShown = {Metric::level, Metric::lre, Metric::mag};

std::string dot(std::string_view color) {
  return fmt::format("<span class=\"dot\" style=\"background:{}\"></span>", color);
}

/// The label of a method.
std::string told(const std::string& method) {
  if (method == "input") return "input: the unchanged sound of the camera";
  if (method == "gtf") return "gtf: without the speaker's position";
  if (method == "dsp") return "dsp: head filters, with the speaker's position";
  return method;
}

/// The method with the smallest error by a metric.
std::size_t best_of(const EarpointResult& result, Metric metric) {
  const auto best = std::ranges::min_element(
      result.renderings, {},
      [&](const RenderedEarpoint& rendered) { return rendered.metrics[metric].value_or(1e9); });
  return static_cast<std::size_t>(best - result.renderings.begin());
}

std::string number_cell(const EarpointResult& result, std::size_t method, Metric metric) {
  const std::optional<double> value = result.renderings[method].metrics[metric];
  if (!value) return "<td>&ndash;</td>";
  return fmt::format("<td{}><b>{:.{}f}</b></td>",
                     best_of(result, metric) == method ? " class=\"best\"" : "", *value,
                     metric == Metric::mag ? 3 : 1);
}

std::string table(const EarpointComparison& comparison) {
  const std::size_t count = comparison.methods.size();
  std::string html = "<table>\n<tr><th></th><th colspan=\"2\" class=\"group\">true sound, dB</th>";
  for (const char* title : {"error of level, dB", "error of left&minus;right, dB", "Mag"}) {
    html += fmt::format("<th colspan=\"{}\" class=\"group\">{}</th>", count, title);
  }
  html += "</tr>\n<tr><th>earpoint</th><th>level</th><th>left&minus;right</th>";
  for (std::size_t metric = 0; metric < kShown.size(); ++metric) {
    for (const ClipMethod& method : comparison.methods) {
      html += fmt::format("<th>{}</th>", escaped(method.name));
    }
  }
  html += "</tr>\n";
  for (std::size_t i = 0; i < comparison.earpoints.size(); ++i) {
    const EarpointResult& result = comparison.earpoints[i];
    html += fmt::format("<tr><td>{}&ensp;{}</td><td>{:+.1f}</td><td>{:+.1f}</td>", i + 1,
                        escaped(comparison.clip.earpoints[i].name), result.truth.level_db,
                        result.truth.left_right_db);
    for (const Metric metric : kShown) {
      for (std::size_t m = 0; m < count; ++m) html += number_cell(result, m, metric);
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

/// "+4.4 dB"; no "-0.0".
std::string signed_db(double db) {
  return fmt::format("{:+.1f} dB", std::abs(db) < 0.05 ? 0.0 : db);
}

std::string player_row(std::string_view color, const std::string& name, const fs::path& sound,
                       const EarLevels& levels) {
  return fmt::format(
      "<div class=\"sound\"><span class=\"name\">{}{}</span>{}<span class=\"soft\">level {}, "
      "left&minus;right {}</span></div>\n",
      dot(color), escaped(name), audio_tag(sound.filename().string()), signed_db(levels.level_db),
      signed_db(levels.left_right_db));
}

/// The truth first, then the methods in reverse order.
std::string players(const EarpointComparison& comparison, std::size_t earpoint,
                    const fs::path& truth) {
  const EarpointResult& result = comparison.earpoints[earpoint];
  std::string html = player_row(kTruthColor, "truth: the true sound there", truth, result.truth);
  for (std::size_t m = comparison.methods.size(); m-- > 0;) {
    const std::string& name = comparison.methods[m].name;
    html += player_row(color_of(m, name), told(name), result.renderings[m].sound,
                       result.renderings[m].levels);
  }
  return html;
}

NamedSound small_sound(const std::string& name, const fs::path& path) {
  return {name, resample(read_sound(path), kMetricRateHz)};
}

std::string plots(const EarpointComparison& comparison, std::size_t earpoint,
                  const fs::path& truth) {
  std::vector<NamedSound> sounds{small_sound("truth", truth)};
  for (std::size_t m = comparison.methods.size(); m-- > 0;) {
    sounds.push_back(small_sound(comparison.methods[m].name,
                                 comparison.earpoints[earpoint].renderings[m].sound));
  }
  return fmt::format("<div class=\"plots\">{}{}{}</div>\n", waveform_plot(sounds),
                     spectrogram_plot(sounds, 0), spectrogram_plot(sounds, 1));
}

std::string card(const EarpointComparison& comparison, std::size_t earpoint,
                 const fs::path& folder) {
  const KnownEarpoint& known = comparison.clip.earpoints[earpoint];
  // Beside the page, so that the folder can be moved.
  const fs::path truth =
      folder / fmt::format("{}-truth{}", earpoint + 1, known.truth.extension().string());
  std::error_code error;
  fs::copy_file(known.truth, truth, fs::copy_options::overwrite_existing, error);
  if (error) throw InputError(truth.string(), "cannot be written: " + error.message());
  const Vector3& at = known.source_from_target.position_m;
  return fmt::format(
      "<div class=\"card\">\n<div class=\"clip-head\"><span class=\"tag\">{}</span>"
      "<h3>{}</h3><span class=\"soft\">{:.1f} m {} the camera, {:.1f} m to its {}, turned "
      "{:.0f} degrees to the {}</span></div>\n"
      "<div class=\"heard\">\n<div class=\"map\">{}<div class=\"caption\">from above; rings "
      "are 1 m apart</div></div>\n<div>{}</div>\n</div>\n{}</div>\n",
      earpoint + 1, escaped(known.name), std::abs(at.x), at.x < 0.0 ? "behind" : "ahead of",
      std::abs(at.y), at.y < 0.0 ? "right" : "left", std::abs(known.yaw_deg),
      known.yaw_deg < 0.0 ? "right" : "left",
      map_svg(known.source_from_target, comparison.clip.speaker_m),
      players(comparison, earpoint, truth), plots(comparison, earpoint, truth));
}

std::string what_the_camera_has(const EarpointComparison& comparison) {
  const EarpointClip& clip = comparison.clip;
  const Image picture = clip_picture(clip);
  std::string html = "<div class=\"card\">\n<div class=\"scene\">\n<div>";
  if (!picture.empty()) {
    html += img_tag(picture, "picture of the camera", "wide");
    html += fmt::format("<div class=\"caption\">picture of the camera{}</div>",
                        clip.speaker_box ? "; the box is the speaker" : "");
  }
  html += fmt::format("<h3>Sound at the camera</h3>{}</div>\n",
                      audio_tag(comparison.source.filename().string()));
  if (clip.map) {
    html += fmt::format(
        "<div>{}<div class=\"caption\">from above; the camera points up, "
        "the earpoints are numbered</div></div>\n",
        img_tag(drawn_map(clip), "map from above", "wide"));
  }
  return html + "</div>\n</div>\n";
}

}  // namespace

void write_earpoint_page(const EarpointComparison& comparison, const fs::path& folder) {
  write_image(folder / "overview.jpg", overview(comparison));
  std::string body = fmt::format(
      "<h1>One moment, heard from elsewhere</h1>\n<p>From one camera's picture and its two ears, "
      "Earpoint renders the sound at other positions. Listen with headphones.</p>\n{}",
      what_the_camera_has(comparison));
  body +=
      "<h2>Errors</h2>\n<p>Level is relative to the sound at the camera; left&minus;right "
      "is the level of the left ear less that of the right. Errors and Mag, a distance of "
      "spectrograms, are best at 0; the best method is blue.</p>\n<div class=\"card\">\n" +
      table(comparison) + "</div>\n<h2>Listen</h2>\n";
  body += fmt::format(
      "<p>To walk through the clip, open <code>{}</code> with <code>earpoint serve</code>.</p>\n",
      escaped(comparison.clip.description.string()));
  for (std::size_t i = 0; i < comparison.earpoints.size(); ++i) {
    body += card(comparison, i, folder);
  }
  write_file(folder / "index.html", page("Earpoint: one moment, heard from elsewhere", body));
}

}  // namespace earpoint

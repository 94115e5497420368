#include <earpoint/evaluate/report.h>

#include "report_figures.h"
#include "report_sounds.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/evaluate/report_html.h>

namespace earpoint {
namespace {

constexpr float kLoudest = 0.9F;

std::string heading_of(Metric metric) {
  const MetricName& name = name_of(metric);
  return fmt::format("<th title=\"{}\">{}{}</th>", escaped(name.meaning), name.heading,
                     name.unit.empty() ? "" : fmt::format(", {}", name.unit));
}

std::string dot(std::size_t index, const std::string& name) {
  return fmt::format("<span class=\"dot\" style=\"background:{}\"></span>", color_of(index, name));
}

bool is_shown(const EvaluationTable& table, Metric metric) {
  return std::ranges::any_of(table.rows,
                             [&](const TableRow& row) { return row[metric].mean.has_value(); });
}

/// The best method by a metric, oracles left out.
std::optional<std::size_t> best_of(const EvaluationTable& table, Metric metric) {
  std::optional<std::size_t> best;
  for (std::size_t m = 0; m < table.rows.size(); ++m) {
    const TableRow& row = table.rows[m];
    if (row.is_oracle || !row[metric].mean) continue;
    if (!best || row[metric].mean->value < table.rows[*best][metric].mean->value) best = m;
  }
  return best;
}

/// @param clips  of the table; a mean over fewer clips states their number
std::string cell(const TableRow::Column& column, int decimals, bool is_best, std::size_t clips) {
  if (!column.mean) return "<td>&ndash;</td>";
  std::string text = fmt::format("<td{}><b>{:.{}f}</b>", is_best ? " class=\"best\"" : "",
                                 column.mean->value, decimals);
  if (column.mean->range) {
    text += fmt::format("<small>{:.{}f} &ndash; {:.{}f}</small>", column.mean->range->low, decimals,
                        column.mean->range->high, decimals);
  }
  if (column.mean->clips < clips) {
    text += fmt::format("<small>over {} of {} clips</small>", column.mean->clips, clips);
  }
  if (column.ratio) text += fmt::format("<small>&times; {:.2f}</small>", column.ratio->value);
  return text + "</td>";
}

std::string main_table(const EvaluationTable& table) {
  std::string html = "<table>\n<tr><th>method</th>";
  for (const Metric metric : told_metrics()) {
    if (is_shown(table, metric)) html += heading_of(metric);
  }
  html += "</tr>\n";
  for (std::size_t m = 0; m < table.rows.size(); ++m) {
    const TableRow& row = table.rows[m];
    html += fmt::format("<tr{}><td>{}{}<small>{}</small></td>",
                        row.is_oracle ? " class=\"oracle\"" : "", dot(m, row.method),
                        escaped(row.method), escaped(row.what));
    for (const Metric metric : told_metrics()) {
      if (!is_shown(table, metric)) continue;
      html += cell(row[metric], name_of(metric).decimals, best_of(table, metric) == m, table.clips);
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string released_table(const EvaluationTable& table) {
  constexpr std::array<Metric, 6> kReleased = {Metric::mag,           Metric::lre, Metric::rte,
                                               Metric::stft_distance, Metric::l2,  Metric::delay};
  std::string html = "<table>\n<tr><th>method</th>";
  for (const Metric metric : kReleased) {
    if (is_shown(table, metric)) html += heading_of(metric);
  }
  html += "<th>batches with a negated ear</th></tr>\n";
  for (const TableRow& row : table.rows) {
    html += fmt::format("<tr{}><td>{}</td>", row.is_oracle ? " class=\"oracle\"" : "",
                        escaped(row.method));
    for (const Metric metric : kReleased) {
      if (!is_shown(table, metric)) continue;
      const TableRow::Column column{row[metric].released, std::nullopt, std::nullopt};
      html += cell(column, name_of(metric).decimals, false, table.clips);
    }
    html += fmt::format("<td>{}</td></tr>\n", row.sign_fixes);
  }
  return html + "</table>\n";
}

std::string curves(const EvaluationResult& result) {
  std::string html = "<div class=\"legend\">";
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    html += fmt::format("<span>{}{}</span>", dot(m, result.methods[m].name),
                        escaped(result.methods[m].name));
  }
  html += "</div>\n<div class=\"figures\">\n";
  for (const Metric metric : {Metric::mag, Metric::lre, Metric::level}) {
    for (const CurveAxis& axis : curve_axes()) {
      if (axis.needs_speaker && !result.clips.front().speaker_m) continue;
      html += curve_svg(result, metric, axis) + "\n";
    }
  }
  return html + "</div>\n";
}

/// A clip to show, and why.
struct ChosenClip {
  std::size_t clip = 0;
  std::string why;
};

std::vector<ChosenClip> choose(const EvaluationResult& result, const ReportOptions& options) {
  std::size_t judge = 0;
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    if (!result.methods[m].is_oracle && result.methods[m].name != "input") judge = m;
  }
  std::vector<std::size_t> order(result.clips.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t clip) {
    return result.clips[clip].honest[judge][Metric::mag].value_or(0.0);
  });
  const std::string& name = result.methods[judge].name;
  std::vector<ChosenClip> chosen{{order.front(), "best Mag of " + name},
                                 {order[order.size() / 2], "median Mag of " + name},
                                 {order.back(), "worst Mag of " + name}};
  RandomStream random(options.seed);
  for (int i = 0; i < options.random_clips; ++i) {
    chosen.push_back({random.index(result.clips.size()), "drawn at random"});
  }
  return chosen;
}

/// The colour and metrics beside a sound of a clip: a method's, or the truth.
struct SoundRow {
  std::string dot;
  const ClipMetrics* metrics = nullptr;  ///< null for the truth
};

/// @param rows  one for each sound
std::string players(std::span<const NamedSound> sounds, std::span<const SoundRow> rows,
                    float gain) {
  std::string html = "<table>\n<tr><th>sound</th><th></th>";
  constexpr std::array<Metric, 4> kShort = {Metric::mag, Metric::lre, Metric::level,
                                            Metric::interaural_delay};
  for (const Metric metric : kShort) html += heading_of(metric);
  html += "</tr>\n";
  for (std::size_t i = 0; i < sounds.size(); ++i) {
    html += fmt::format("<tr><td>{}{}</td><td>{}</td>", rows[i].dot, escaped(sounds[i].name),
                        audio_tag(sounds[i].wave, gain));
    for (const Metric metric : kShort) {
      const std::optional<double> value =
          rows[i].metrics != nullptr ? (*rows[i].metrics)[metric] : std::nullopt;
      html += value ? fmt::format("<td>{:.{}f}</td>", *value, name_of(metric).decimals)
                    : std::string("<td></td>");
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string picture(const PairSample& sample) {
  if (!sample.picture) return "<div class=\"caption\">no picture</div>";
  return img_tag(boxed(*sample.picture, sample.speaker_box), "picture of the source view",
                 "picture") +
         (sample.speaker_box
              ? "<div class=\"caption\">picture of the source view; the box is the speaker</div>"
              : "<div class=\"caption\">picture of the source view; the speaker is out of "
                "sight</div>");
}

std::string clip_card(const ChosenClip& chosen, const EvaluationSet& set,
                      std::span<const MethodEntry> methods, const EvaluationResult& result) {
  const ClipResult& clip = result.clips[chosen.clip];
  const PairSample sample = set.sample(clip.pair);
  std::vector<NamedSound> sounds;
  std::vector<SoundRow> rows;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (methods[m].is_oracle) continue;
    sounds.push_back(
        {methods[m].name, ask(*methods[m].make(), methods[m], sample, clip.scene, nullptr)});
    rows.push_back({dot(m, methods[m].name), &clip.honest[m]});
  }
  sounds.push_back({"truth", sample.target});
  rows.push_back({fmt::format("<span class=\"dot\" style=\"background:{}\"></span>", kTruthColor)});
  float peak = 0.0F;
  for (const NamedSound& sound : sounds) {
    for (const float x : sound.wave.planar()) peak = std::max(peak, std::abs(x));
  }
  const float gain = peak > 0.0F ? kLoudest / peak : 1.0F;

  std::string html = fmt::format(
      "<div class=\"card\">\n<div class=\"clip-head\"><span class=\"tag\">{}</span><h3>{}</h3>"
      "</div>\n<div class=\"clip\">\n<div>{}</div>\n",
      escaped(chosen.why), escaped(clip.name), picture(sample));
  html += fmt::format(
      "<div class=\"map\">{}<div class=\"caption\">from above; rings are 1 m apart</div></div>\n"
      "<div>{}</div>\n</div>\n",
      map_svg(clip.source_from_target, clip.speaker_m), players(sounds, rows, gain));
  return html + fmt::format("<div class=\"plots\">{}{}{}</div>\n</div>\n", waveform_plot(sounds),
                            spectrogram_plot(sounds, 0), spectrogram_plot(sounds, 1));
}

std::string head_of(const EvaluationTable& table, const ReportOptions& options) {
  std::string html = fmt::format(
      "<h1>Methods compared with the true sound</h1>\n<p class=\"soft\">{}, split {}: {}. Pairs: "
      "{}.</p>\n",
      escaped(options.data), escaped(options.split), extent_of(table), escaped(options.pairs));
  html += fmt::format(
      "<h2>Methods</h2>\n<p>Every number is an error, and 0 is best. Below each mean are its "
      "95&nbsp;% interval, drawn by {}, and its ratio to <em>input</em>, the source's "
      "unchanged sound. The best method is blue. Oracles are given part of the answer: they show "
      "how much error could be removed.</p>\n",
      table.interval_unit());
  html += "<div class=\"card\">\n" + main_table(table) + "</div>\n";
  html +=
      "<details><summary>With the published evaluation's use of the target</summary>\n<p>It "
      "negates one ear "
      "of a batch of 32 renderings if that reduces the difference to the target. Metrics of "
      "magnitudes do not change; those of samples do.</p>\n<div class=\"card\">\n" +
      released_table(table) + "</div></details>\n";
  if (!table.skipped.empty()) {
    html += fmt::format("<details><summary>{} pairs could not be read</summary>\n<ul>\n",
                        table.skipped.size());
    for (const BadPair& pair : table.skipped) {
      html += fmt::format("<li>{}: {}</li>\n", escaped(pair.name), escaped(pair.problem));
    }
    html += "</ul></details>\n";
  }
  return html;
}

}  // namespace

void write_report(const std::filesystem::path& folder, const EvaluationSet& set,
                  std::span<const MethodEntry> methods, const EvaluationResult& result,
                  const ReportOptions& options, ProgressSink& progress) {
  create_folder(folder);
  std::string body = head_of(make_table(result), options);
  body +=
      "<h2>Error over distance and angle</h2>\n<p>Five bins of equally many clips; bars are "
      "95&nbsp;% "
      "intervals.</p>\n<div class=\"card\">\n" +
      curves(result) + "</div>\n";
  body +=
      "<h2>Clips</h2>\n<p>Listen with headphones. The sounds of a clip share one gain, so "
      "their loudness can be compared. <code>earpoint serve</code> walks through them.</p>\n";
  const std::vector<ChosenClip> chosen = choose(result, options);
  progress.begin("drawing the report", static_cast<double>(chosen.size()), "clips");
  for (const ChosenClip& clip : chosen) {
    body += clip_card(clip, set, methods, result);
    progress.advance(1.0);
  }
  progress.finish();
  write_file(folder / "index.html", page("Earpoint: methods compared with the true sound", body));
}

}  // namespace earpoint

#include "study_page.h"

#include <algorithm>

#include <fmt/format.h>

#include <earpoint/evaluate/report_html.h>

namespace earpoint {
namespace {

constexpr double kBarWidth = 420.0;
constexpr double kBarHeight = 26.0;
constexpr double kBarLeft = 110.0;

/// How numbers are shown: shares in percent, ratings unchanged.
struct Unit {
  double factor = 1.0;
  const char* sign = "";
};

Unit unit_of(const Study& study) {
  return study.design == StudyDesign::choice ? Unit{100.0, "&thinsp;%"} : Unit{};
}

std::string estimate_cell(const std::optional<Estimate>& estimate, const Unit& unit, bool is_best) {
  if (!estimate) return "<td>&ndash;</td>";
  std::string cell = fmt::format("<td{}><b>{:.0f}{}</b>", is_best ? " class=\"best\"" : "",
                                 unit.factor * estimate->value, unit.sign);
  if (estimate->range) {
    cell += fmt::format("<small>{:.0f} to {:.0f}</small>", unit.factor * estimate->range->low,
                        unit.factor * estimate->range->high);
  }
  return cell + "</td>";
}

std::vector<const StudyRow*> rows_of(const StudyGroup& group, const std::string& scale) {
  std::vector<const StudyRow*> rows;
  for (const StudyRow& row : group.rows) {
    if (row.scale == scale) rows.push_back(&row);
  }
  return rows;
}

std::vector<std::string> scales_of(const StudyGroup& group) {
  std::vector<std::string> scales;
  for (const StudyRow& row : group.rows) {
    if (std::ranges::find(scales, row.scale) == scales.end()) scales.push_back(row.scale);
  }
  return scales;
}

bool is_condition(const StudyRow& row) {
  return row.condition == kTruthCondition || row.condition == kMonoCondition ||
         row.condition == kSwappedCondition;
}

/// As the paper's table 4: a column for each method, the best in colour.
std::string table(const Study& study, const StudyGroup& group) {
  const std::vector<std::string> scales = scales_of(group);
  std::string html = "<table><tr><th>Data set</th>";
  if (scales.size() > 1) html += "<th>Scale</th>";
  for (const StudyRow* row : rows_of(group, scales.front())) {
    html += fmt::format("<th>{}</th>", escaped(row->condition));
  }
  html += "</tr>";
  for (const std::string& scale : scales) {
    const auto rows = rows_of(group, scale);
    double best = -1.0;
    for (const StudyRow* row : rows) {
      if (row->value && !is_condition(*row)) best = std::max(best, row->value->value);
    }
    html += fmt::format("<tr><td>{}</td>", escaped(study.data));
    if (scales.size() > 1) html += fmt::format("<td>{}</td>", escaped(scale));
    for (const StudyRow* row : rows) {
      const bool is_best = row->value && !is_condition(*row) && row->value->value == best;
      html += estimate_cell(row->value, unit_of(study), is_best);
    }
    html += "</tr>";
  }
  return html + "</table>";
}

/// Bars with their intervals, as SVG.
std::string bars(const Study& study, const StudyGroup& group, const std::string& scale) {
  const auto rows = rows_of(group, scale);
  const double most = study.design == StudyDesign::choice ? 1.0 : 100.0;
  const auto x = [&](double value) { return kBarLeft + value / most * kBarWidth; };
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" width=\"{}\" style=\"max-width:100%\" role=\"img\" "
      "aria-label=\"{} by method\" font-family=\"sans-serif\" font-size=\"13\">",
      kBarLeft + kBarWidth + 60.0, kBarHeight * static_cast<double>(rows.size()),
      kBarLeft + kBarWidth + 60.0, scale.empty() ? "share" : scale);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const StudyRow& row = *rows[i];
    const double y = kBarHeight * (static_cast<double>(i) + 0.5);
    svg += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\" fill=\"#1d2430\">{}</text>",
                       kBarLeft - 8, y + 4.5, escaped(row.condition));
    if (!row.value) continue;
    svg +=
        fmt::format("<rect x=\"{}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"14\" fill=\"{}\"/>",
                    kBarLeft, y - 7.0, x(row.value->value) - kBarLeft, color_of(i, row.condition));
    if (!row.value->range) continue;
    svg += fmt::format(
        "<line x1=\"{0:.1f}\" x2=\"{1:.1f}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"#1d2430\" "
        "stroke-width=\"1.5\"/>",
        x(row.value->range->low), x(row.value->range->high), y);
  }
  return svg + "</svg>";
}

std::string votes_cell(const SignVotes& votes) {
  return fmt::format("<td>{} : {}<small>p = {:.2g}</small></td>", votes.wins, votes.losses,
                     votes.p);
}

std::string power_cell(const SignVotes& votes) {
  const std::string least = votes.detectable
                                ? fmt::format("{:.0f}&thinsp;%", 100.0 * *votes.detectable)
                                : std::string("none");
  return fmt::format("<td>{:.0f}&thinsp;%<small>finds {}</small></td>", 100.0 * votes.power, least);
}

std::string comparisons(const StudyGroup& group) {
  if (group.comparisons.empty()) return {};
  std::string html = fmt::format(
      "<h3>Against the baselines</h3><div class=\"card\"><table><tr><th>Method</th>"
      "<th>Baseline</th><th>Scale</th><th>Preferred</th><th>By answer</th><th>By participant</th>"
      "<th>By clip</th><th>Power, answers</th><th>Power, participants</th></tr>");
  for (const StudyComparison& c : group.comparisons) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td>", escaped(c.method),
                        escaped(c.baseline), escaped(c.scale));
    html += estimate_cell(c.preference, {100.0, "&thinsp;%"}, false);
    html += votes_cell(c.by_answer) + votes_cell(c.by_participant) + votes_cell(c.by_clip) +
            power_cell(c.by_answer) + power_cell(c.by_participant) + "</tr>";
  }
  return html +
         fmt::format(
             "</table></div><p class=\"soft\">Exact two-sided sign tests, ties left out, not "
             "corrected for their number. By answer takes all answers as independent, which "
             "they are not; by participant and by clip count one vote each. Power: how "
             "likely the test finds a true preference of {:.0f}&thinsp;%; below it the "
             "smallest preference that it finds with 80&thinsp;%.</p>",
             100.0 * kPowerShare);
}

std::string left_out(const StudyGroup& group) {
  std::string items;
  for (const StudyParticipant& participant : group.participants) {
    if (participant.left_out.empty()) continue;
    items += fmt::format("<li>Participant {} {}.</li>", participant.participant.number,
                         escaped(participant.left_out));
  }
  return items.empty() ? "<p>Nobody was left out.</p>" : "<ul>" + items + "</ul>";
}

std::string screening(const Study& study, const StudyGroup& group) {
  std::string html =
      "<h3>Who counts</h3>" + left_out(group) +
      "<details><summary>Before screening, all who finished</summary><table><tr><th>Sound</th>"
      "<th>Scale</th><th>Value</th></tr>";
  for (const StudyRow& row : group.rows) {
    html += fmt::format("<tr><td>{}</td><td>{}</td>", escaped(row.condition), escaped(row.scale)) +
            estimate_cell(row.before_screening, unit_of(study), false) + "</tr>";
  }
  html += "</table></details>";
  if (group.by_place.empty() || group.answers == 0) return html;
  html += "<p class=\"soft\">Choices by the sound's place on the page:";
  for (std::size_t place = 0; place < group.by_place.size(); ++place) {
    html += fmt::format(" {}: {:.0f}&thinsp;%", static_cast<char>('A' + place),
                        100.0 * group.by_place[place]);
  }
  return html + ".</p>";
}

std::string group_section(const Study& study, const StudyGroup& group) {
  std::string html = fmt::format(
      "<h2>{}</h2>", group.is_simulated
                         ? "Simulated participants, not people: " + escaped(group.name.substr(11))
                         : "People");
  html += fmt::format("<p>{} of {} participants count, with {} answers.</p>", group.counted,
                      group.participants.size(), group.answers);
  html += "<div class=\"card\">" + table(study, group) + "</div>";
  if (group.answers == 0) return html + screening(study, group);
  for (const std::string& scale : scales_of(group)) {
    html += fmt::format("<div class=\"card\">{}{}</div>",
                        scale.empty() ? "" : "<h3>" + escaped(scale) + "</h3>",
                        bars(study, group, scale));
  }
  return html + comparisons(group) + screening(study, group);
}

}  // namespace

std::string study_page(const Study& study, std::span<const StudyGroup> groups) {
  const auto clips =
      std::ranges::count_if(study.clips, [](const StudyClip& clip) { return !clip.is_control; });
  std::string body = fmt::format(
      "<h1>{}</h1><p class=\"soft\">{} clips of {} s from {} ({}, {}), seed {}, loudness {}. {} "
      "Intervals hold 95&thinsp;%, drawn over participants and clips.</p>",
      escaped(study.title), clips, study.duration_s, escaped(study.data), escaped(study.split),
      escaped(study.pairs), study.seed, study.loudness_matched ? "matched" : "kept",
      study.design == StudyDesign::choice
          ? "Share of answers that chose a method's sound as the closest to what is heard at the "
            "target, with the target's picture and sound as reference."
          : "Mean ratings from 0 to 100 against the target's sound, which is hidden among the "
            "rated sounds as truth; mono and swapped ears are anchors of place.");
  if (groups.empty()) body += "<p>Nobody has taken part yet.</p>";
  for (const StudyGroup& group : groups) body += group_section(study, group);
  body += "<h2>Methods</h2><ul>";
  for (const StudyMethod& method : study.methods) {
    body += fmt::format("<li>{}: {}{}</li>", escaped(method.name), escaped(method.what),
                        method.is_baseline ? " (baseline)" : "");
  }
  return page(study.title, body + "</ul>");
}

}  // namespace earpoint

#include <earpoint/evaluate/evaluation_table.h>

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace earpoint {
namespace {

using Json = nlohmann::ordered_json;
using Values = std::vector<std::optional<double>>;

Values values_of(const EvaluationResult& result, std::size_t method, Metric metric, bool released) {
  Values values;
  for (const ClipResult& clip : result.clips) {
    values.push_back((released ? clip.released : clip.honest)[method][metric]);
  }
  return values;
}

Json json_of(const std::optional<Estimate>& estimate, const char* name) {
  if (!estimate) return nullptr;
  Json json;
  json[name] = estimate->value;
  json["low"] = estimate->range ? Json(estimate->range->low) : Json();
  json["high"] = estimate->range ? Json(estimate->range->high) : Json();
  return json;
}

Json json_of(const TableRow& row) {
  Json json;
  json["method"] = row.method;
  json["what"] = row.what;
  json["is_oracle"] = row.is_oracle;
  Json released;
  for (const Metric metric : all_metrics()) {
    const TableRow::Column& column = row[metric];
    if (!column.mean) continue;
    const std::string key(name_of(metric).key);
    json[key] = json_of(column.mean, "mean");
    json[key]["clips"] = column.mean->clips;
    json[key]["ratio"] = json_of(column.ratio, "value");
    released[key] = json_of(column.released, "mean");
  }
  released["sign_fixes"] = row.sign_fixes;
  json["released"] = std::move(released);
  return json;
}

std::string with_range(const std::optional<Estimate>& estimate, int decimals) {
  if (!estimate) return "-";
  if (!estimate->range) return fmt::format("{:.{}f}", estimate->value, decimals);
  return fmt::format("{:.{}f} [{:.{}f}, {:.{}f}]", estimate->value, decimals, estimate->range->low,
                     decimals, estimate->range->high, decimals);
}

/// A table of one cell per method and metric.
template <typename Cell>
std::string text_of(const EvaluationTable& table, const std::string& title,
                    std::span<const Metric> metrics, const Cell& cell) {
  std::vector<std::vector<std::string>> lines{{title}};
  for (const Metric metric : metrics) {
    const MetricName& name = name_of(metric);
    lines[0].push_back(name.unit.empty() ? std::string(name.heading)
                                         : fmt::format("{}, {}", name.heading, name.unit));
  }
  for (const TableRow& row : table.rows) {
    lines.push_back({row.method});
    for (const Metric metric : metrics) lines.back().push_back(cell(row, metric));
  }
  std::vector<std::size_t> widths(lines[0].size());
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  }
  std::string text;
  for (const auto& line : lines) {
    text += fmt::format("{:<{}}", line[0], widths[0]);
    for (std::size_t i = 1; i < line.size(); ++i) {
      text += fmt::format("  {:>{}}", line[i], widths[i]);
    }
    text += '\n';
  }
  return text;
}

/// Counts homes, conversations and voices.
void count_extent(const EvaluationResult& result, EvaluationTable& table) {
  std::set<std::string> homes;
  std::set<std::string> voices;
  std::set<int> conversations;
  for (const ClipResult& clip : result.clips) {
    homes.insert(clip.scene);
    conversations.insert(clip.cluster);
    if (clip.voice) voices.insert(*clip.voice);
  }
  table.homes = homes.size();
  table.conversations = conversations.size();
  if (!voices.empty()) table.voices = voices.size();
}

/// "*" if clips without a value are left out.
const char* star(const std::optional<Estimate>& estimate, const EvaluationTable& table) {
  return estimate && estimate->clips < table.clips ? "*" : "";
}

/// The note on the stars: the fewest clips of each metric's means. Empty if there is no star.
std::string stars_of(const EvaluationTable& table, std::span<const Metric> metrics) {
  std::string text;
  for (const Metric metric : metrics) {
    std::size_t fewest = table.clips;
    for (const TableRow& row : table.rows) {
      if (row[metric].mean) fewest = std::min(fewest, row[metric].mean->clips);
    }
    if (fewest == table.clips) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name_of(metric).heading, fewest);
  }
  return text.empty() ? text
                      : fmt::format("* mean over fewer clips, those that have a value: {} of {}.\n",
                                    text, table.clips);
}

std::string counted(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// The metrics that at least one row has.
std::vector<Metric> present(const EvaluationTable& table, std::span<const Metric> told) {
  std::vector<Metric> metrics;
  for (const Metric metric : told) {
    if (std::ranges::any_of(table.rows,
                            [&](const TableRow& row) { return row[metric].mean.has_value(); })) {
      metrics.push_back(metric);
    }
  }
  return metrics;
}

}  // namespace

std::vector<int> interval_clusters(const EvaluationResult& result) {
  std::map<std::string, int> homes;
  std::vector<int> by_home;
  std::vector<int> by_conversation;
  for (const ClipResult& clip : result.clips) {
    by_home.push_back(homes.try_emplace(clip.scene, static_cast<int>(homes.size())).first->second);
    by_conversation.push_back(clip.cluster);
  }
  return homes.size() > 1 ? by_home : by_conversation;
}

std::string extent_of(const EvaluationTable& table) {
  const std::string voices = table.voices ? ", " + counted(*table.voices, "voice") : std::string();
  return fmt::format("{} of {} in {}{}", counted(table.clips, "clip"),
                     counted(table.conversations, "conversation"), counted(table.homes, "home"),
                     voices);
}

EvaluationTable make_table(const EvaluationResult& result) {
  const ClusterBootstrap bootstrap(interval_clusters(result));
  const auto input = std::ranges::find(result.methods, "input", &EvaluationResult::Row::name);

  EvaluationTable table{.rows = {},
                        .clips = result.clips.size(),
                        .conversations = 0,
                        .homes = 0,
                        .voices = std::nullopt,
                        .skipped = result.skipped};
  count_extent(result, table);
  Values heard;
  Values primary;
  for (const ClipResult& clip : result.clips) {
    heard.push_back(clip.heard_si_sdr_db);
    primary.push_back(clip.primary_si_sdr_db);
  }
  table.heard_si_sdr_db = bootstrap.mean(heard);
  table.primary_si_sdr_db = bootstrap.mean(primary);
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    const EvaluationResult::Row& method = result.methods[m];
    TableRow row{.method = method.name,
                 .what = method.what,
                 .is_oracle = method.is_oracle,
                 .sign_fixes = method.sign_fixes,
                 .columns = {}};
    for (const Metric metric : all_metrics()) {
      const Values values = values_of(result, m, metric, false);
      TableRow::Column& column = row.columns[static_cast<std::size_t>(metric)];
      column.mean = bootstrap.mean(values);
      column.released = bootstrap.mean(values_of(result, m, metric, true));
      if (input != result.methods.end() && name_of(metric).is_error) {
        const auto baseline = static_cast<std::size_t>(input - result.methods.begin());
        column.ratio = bootstrap.ratio(values, values_of(result, baseline, metric, false));
      }
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string json_of(const EvaluationTable& table, const EvaluationSubject& subject) {
  Json json;
  json["data"] = subject.data;
  json["split"] = subject.split;
  json["target"] = subject.target == PairTarget::viewpoint ? "viewpoint" : "near_microphone";
  json["ambient_db"] = subject.ambient_db ? Json(*subject.ambient_db) : Json();
  json["ambient_separation"] =
      subject.ambient_db ? Json(std::string(name_of(subject.separation))) : Json();
  json["heard_si_sdr_db"] = json_of(table.heard_si_sdr_db, "mean");
  json["primary_si_sdr_db"] = json_of(table.primary_si_sdr_db, "mean");
  json["context_s"] = subject.context_s;
  json["boxes"] = subject.boxes;
  json["pairs"] = subject.pairs;
  json["clips"] = table.clips;
  json["conversations"] = table.conversations;
  json["homes"] = table.homes;
  json["voices"] = table.voices ? Json(*table.voices) : Json();
  json["intervals_by"] = table.interval_unit();
  json["skipped"] = Json::array();
  for (const BadPair& pair : table.skipped) {
    json["skipped"].push_back({{"pair", pair.name}, {"problem", pair.problem}});
  }
  json["rows"] = Json::array();
  for (const TableRow& row : table.rows) json["rows"].push_back(json_of(row));
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string text_of(const EvaluationTable& table, std::span<const Metric> told) {
  const std::vector<Metric> metrics = present(table, told);
  const auto with_star = [&](const std::optional<Estimate>& estimate, int decimals) {
    return with_range(estimate, decimals) + star(estimate, table);
  };
  std::string text = text_of(table, "mean", metrics, [&](const TableRow& row, Metric metric) {
    return with_star(row[metric].mean, name_of(metric).decimals);
  });
  std::vector<Metric> errors = metrics;
  std::erase_if(errors, [](Metric metric) { return !name_of(metric).is_error; });
  text += '\n' + text_of(table, "of input", errors, [&](const TableRow& row, Metric metric) {
            return with_star(row[metric].ratio, 2);
          });
  text += '\n' + text_of(table, "released", metrics, [&](const TableRow& row, Metric metric) {
            const auto& released = row[metric].released;
            return released ? fmt::format("{:.{}f}{}", released->value, name_of(metric).decimals,
                                          star(released, table))
                            : std::string("-");
          });
  if (table.primary_si_sdr_db) {
    text +=
        fmt::format("\nSI-SDR of the source's primary sound: {} dB; of its whole sound: {} dB.\n",
                    with_range(table.primary_si_sdr_db, 1), with_range(table.heard_si_sdr_db, 1));
  }
  const bool has_gains =
      std::ranges::any_of(metrics, [](Metric metric) { return !name_of(metric).is_error; });
  return text + '\n' + stars_of(table, metrics) +
         fmt::format(
             "{}; 0 is best{}. [95 % interval], drawn by {}.\n"
             "\"released\": with the published evaluation's use of the target.\n",
             extent_of(table), has_gains ? "; of SI-SDR and ESTOI more is better" : "",
             table.interval_unit());
}

}  // namespace earpoint

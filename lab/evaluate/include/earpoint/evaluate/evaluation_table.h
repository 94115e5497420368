#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/audio/ambient_separation.h>
#include <earpoint/evaluate/bootstrap.h>
#include <earpoint/evaluate/clip_metrics.h>
#include <earpoint/evaluate/evaluation.h>

namespace earpoint {

/// One method's metrics over all clips.
struct TableRow {
  std::string method;
  std::string what;
  bool is_oracle = false;
  std::size_t sign_fixes = 0;  ///< batches in which the released evaluation negated an ear

  struct Column {
    std::optional<Estimate> mean;      ///< nothing if no clip has a value
    std::optional<Estimate> ratio;     ///< to the row `input`, over the clips that both have;
                                       ///< none where MetricName::is_error is false
    std::optional<Estimate> released;  ///< mean with the released evaluation's oracles
  };
  std::array<Column, kMetricCount> columns;

  [[nodiscard]] const Column& operator[](Metric metric) const {
    return columns[static_cast<std::size_t>(metric)];
  }
};

/// What an evaluation comes to.
struct EvaluationTable {
  std::vector<TableRow> rows;
  std::size_t clips = 0;
  std::size_t conversations = 0;
  std::size_t homes = 0;              ///< of recordings, sessions
  std::optional<std::size_t> voices;  ///< nothing where the data do not tell
  std::vector<BadPair> skipped;
  /// ClipResult::heard_si_sdr_db and primary_si_sdr_db over all clips, where sound was separated.
  std::optional<Estimate> heard_si_sdr_db{};
  std::optional<Estimate> primary_si_sdr_db{};

  /// What intervals are drawn by.
  [[nodiscard]] std::string_view interval_unit() const {
    return homes > 1 ? "home" : "conversation";
  }
};

/// The cluster of every clip that intervals are drawn by. Conversations of one home share its
/// rooms, so it is the home where there are several, else the conversation.
[[nodiscard]] std::vector<int> interval_clusters(const EvaluationResult& result);

/// "36 clips of 12 conversations in 3 homes, 4 voices"
[[nodiscard]] std::string extent_of(const EvaluationTable& table);

/// Means with 95 % intervals, over clips, bootstrapped by interval_clusters().
[[nodiscard]] EvaluationTable make_table(const EvaluationResult& result);

/// What an evaluation's pairs are of, for those who read it.
struct EvaluationSubject {
  std::string data;
  std::string split;
  std::string pairs;  ///< where they come from
  PairTarget target = PairTarget::viewpoint;
  std::optional<double> ambient_db;  ///< as with_ambient() has it
  AmbientSeparation separation = AmbientSeparation::bandpass;
  double context_s = 0.0;      ///< of sound before the window
  std::string boxes = "true";  ///< what methods were told; as boxes_named() knows it
};

/// @return the JSON of `earpoint evaluate --json`; docs/formats.md describes it
[[nodiscard]] std::string json_of(const EvaluationTable& table, const EvaluationSubject& subject);

/// @param metrics  that have columns, unless no row has a value
/// @return tables for people, in plain text
[[nodiscard]] std::string text_of(const EvaluationTable& table,
                                  std::span<const Metric> metrics = told_metrics());

}  // namespace earpoint

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <earpoint/waveform.h>

namespace earpoint {

/// One line of the result: its JSON key, its value and what a table says about it.
struct MetricsRow {
  std::string key;
  nlohmann::ordered_json value;  ///< a number, or null where the metric has no value
  std::string unit;
};

/// What `earpoint metrics` prints.
struct MetricsReport {
  std::vector<MetricsRow> rows;
  std::vector<std::string> notes;
  nlohmann::ordered_json extra = nlohmann::ordered_json::object();  ///< in JSON alone
};

/// Brings a sound to the rate that its metrics are published at, and notes that.
void to_rate(Waveform& wave, int rate_hz, const std::filesystem::path& path, MetricsReport& report);

/// What `--json` prints of it: the rows, the extra keys, the notes.
[[nodiscard]] nlohmann::ordered_json json_of(const MetricsReport& report);

void print_report(const MetricsReport& report, bool as_json);

}  // namespace earpoint

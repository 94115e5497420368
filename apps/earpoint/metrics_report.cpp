#include "metrics_report.h"

#include "json_text.h"

#include <fmt/format.h>

#include <earpoint/audio/resample.h>

namespace earpoint {

void to_rate(Waveform& wave, int rate_hz, const std::filesystem::path& path,
             MetricsReport& report) {
  if (wave.sample_rate_hz() == rate_hz) return;
  report.notes.push_back(
      fmt::format("{} resampled from {} to {} Hz", path.string(), wave.sample_rate_hz(), rate_hz));
  wave = resample(wave, rate_hz);
}

nlohmann::ordered_json json_of(const MetricsReport& report) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const MetricsRow& row : report.rows) json[row.key] = row.value;
  json.update(report.extra);
  json["notes"] = report.notes;
  return json;
}

void print_report(const MetricsReport& report, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", json_text(json_of(report)));
    return;
  }
  for (const MetricsRow& row : report.rows) {
    const std::string value =
        row.value.is_null() ? "-" : fmt::format("{:.6g}", row.value.get<double>());
    fmt::print("{:<18}{:>14}{}{}\n", row.key, value, row.unit.empty() ? "" : " ", row.unit);
  }
  for (const std::string& note : report.notes) fmt::print("note: {}\n", note);
}

}  // namespace earpoint

#include "response_report.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/iso3382.h>
#include <earpoint/evaluate/response_metrics.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kInvalidT60 =
    "a decay is too short for T60: t60_error_percent is 100, as in the released evaluation";

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

void add_raf(const ResponsePair& pair, MetricsReport& report) {
  const RafMetrics m = raf_metrics(pair);
  report.rows = {{"stft_error", m.stft_error, ""},
                 {"t60_error_percent", json_of(m.t60_error_percent), "%"},
                 {"edt_error_s", json_of(m.edt_error_s), "s"},
                 {"c50_error_db", json_of(m.c50_error_db), "dB"}};
  report.extra["t60_invalid"] = m.t60_invalid;
  if (m.t60_invalid) report.notes.emplace_back(kInvalidT60);
}

void add_naf(const ResponsePair& pair, MetricsReport& report) {
  const NafMetrics m = naf_metrics(pair);
  report.rows = {{"spectral_loss", m.spectral_loss, ""},
                 {"t60_error_percent", json_of(m.t60_error_percent), "%"}};
  report.extra["t60_invalid"] = m.t60_invalid;
  if (m.t60_invalid) report.notes.emplace_back(kInvalidT60);
}

void add_avr(const ResponsePair& pair, MetricsReport& report) {
  const AvrMetrics m = avr_metrics(pair);
  report.rows = {{"phase", m.phase, ""},
                 {"amp", m.amp, ""},
                 {"env", m.env, ""},
                 {"t60_error_percent", json_of(m.t60_error_percent), "%"},
                 {"edt_error_s", m.edt_error_s, "s"},
                 {"c50_error_db", json_of(m.c50_error_db), "dB"},
                 {"multi_stft", m.multi_stft, ""}};
}

Json json_of(const std::vector<std::vector<IsoBand>>& channels) {
  Json list = Json::array();
  for (const std::vector<IsoBand>& bands : channels) {
    Json channel = Json::array();
    for (const IsoBand& band : bands) {
      channel.push_back({{"centre_hz", band.centre_hz},
                         {"edt_s", json_of(band.edt_s)},
                         {"t20_s", json_of(band.t20_s)},
                         {"t30_s", json_of(band.t30_s)},
                         {"c50_db", band.c50_db},
                         {"c80_db", band.c80_db},
                         {"d50", band.d50},
                         {"ts_ms", 1000.0 * band.ts_s}});
    }
    list.push_back(std::move(channel));
  }
  return list;
}

void add_iso(const ResponsePair& pair, MetricsReport& report) {
  const IsoMetrics m = iso_metrics(pair);
  report.rows = {{"edt_error_percent", json_of(m.edt_error_percent), "%"},
                 {"t20_error_percent", json_of(m.t20_error_percent), "%"},
                 {"t30_error_percent", json_of(m.t30_error_percent), "%"},
                 {"c50_error_db", m.c50_error_db, "dB"},
                 {"c80_error_db", m.c80_error_db, "dB"},
                 {"d50_error", m.d50_error, ""},
                 {"ts_error_ms", m.ts_error_ms, "ms"}};
  report.extra["reference"] = json_of(m.reference);
  report.extra["estimate"] = json_of(m.estimate);
  if (!m.t30_error_percent) {
    report.notes.emplace_back("a decay does not reach the level that a missing time needs");
  }
}

}  // namespace

MetricsReport response_report(MetricConvention convention, const ResponsePair& pair) {
  MetricsReport report;
  if (convention == MetricConvention::raf) add_raf(pair, report);
  if (convention == MetricConvention::naf) add_naf(pair, report);
  if (convention == MetricConvention::avr) add_avr(pair, report);
  if (convention == MetricConvention::iso) add_iso(pair, report);
  report.extra["samples"] = pair.reference.samples();
  report.extra["sample_rate_hz"] = pair.reference.sample_rate_hz();
  return report;
}

MetricsReport response_report(MetricConvention convention, Waveform reference,
                              const std::string& reference_name, Waveform estimate,
                              const std::string& estimate_name, std::optional<double> length_s) {
  MetricsReport resampled;
  if (convention == MetricConvention::raf || convention == MetricConvention::naf) {
    const int rate_hz = convention_rate_hz(convention, reference.sample_rate_hz());
    to_rate(reference, rate_hz, reference_name, resampled);
    to_rate(estimate, rate_hz, estimate_name, resampled);
  }
  const std::ptrdiff_t shorter = std::min(reference.samples(), estimate.samples());
  const std::string& ended =
      reference.samples() < estimate.samples() ? reference_name : estimate_name;
  const ResponsePair pair =
      response_pair(std::move(reference), reference_name, std::move(estimate), estimate_name,
                    length_s ? length_s : compared_length_s(convention));
  MetricsReport report = response_report(convention, pair);
  report.notes.insert(report.notes.begin(), resampled.notes.begin(), resampled.notes.end());
  if (shorter < pair.reference.samples()) {
    report.notes.push_back(fmt::format("{} ends after {} of {} samples; zeros follow", ended,
                                       shorter, pair.reference.samples()));
  }
  return report;
}

MetricsReport response_report(MetricConvention convention, const fs::path& reference,
                              const fs::path& estimate, std::optional<double> length_s) {
  Waveform truth = read_sound(stored_input(reference));
  Waveform found = read_sound(stored_input(estimate));
  return response_report(convention, std::move(truth), reference.string(), std::move(found),
                         estimate.string(), length_s);
}

}  // namespace earpoint

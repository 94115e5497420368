#include "arrays.h"
#include "bindings.h"
#include "json_text.h"
#include "response_report.h"

#include <optional>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <earpoint/audio/resample.h>
#include <earpoint/evaluate/metric_convention.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/evaluate/reverberation_error.h>
#include <earpoint/rt60/weights.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

/// Both sounds at the rate that their metrics are published at, and what was done to them.
struct Pair {
  Waveform reference;
  Waveform estimate;
  py::list notes;
};

Pair pair_of(const py::array& reference, const py::array& estimate, int rate, int metric_rate) {
  Pair pair{waveform_of(reference, rate, "reference"), waveform_of(estimate, rate, "estimate"),
            py::list()};
  check_comparable(pair.reference, "reference", pair.estimate, "estimate");
  if (rate == metric_rate) return pair;
  without_lock([&] {
    pair.reference = resample(pair.reference, metric_rate);
    pair.estimate = resample(pair.estimate, metric_rate);
  });
  for (const char* name : {"reference", "estimate"}) {
    pair.notes.append(fmt::format("{} resampled from {} to {} Hz", name, rate, metric_rate));
  }
  return pair;
}

void add_common(py::dict& result, const Pair& pair) {
  result["samples"] = pair.reference.samples();
  result["sample_rate_hz"] = pair.reference.sample_rate_hz();
  result["notes"] = pair.notes;
}

/// @return what was done
const char* fix_sign_of(Pair& pair) {
  switch (fix_sign(std::span(&pair.estimate, 1), std::span(&pair.reference, 1))) {
    case SignFix::negated_left:
      return "the sign fix negated the left ear";
    case SignFix::negated_right:
      return "the sign fix negated the right ear";
    case SignFix::none:
      break;
  }
  return "the sign fix changed nothing";
}

/// The keys of `earpoint metrics --json`, in its order.
py::dict vigas_metrics(const py::array& reference, const py::array& estimate, int rate,
                       bool sign_fix, const std::optional<std::string>& rt60_model) {
  Pair pair = pair_of(reference, estimate, rate, kMetricRateHz);
  if (sign_fix) pair.notes.append(fix_sign_of(pair));
  std::optional<double> rte_s;
  const BinauralMetrics metrics = without_lock([&] {
    if (rt60_model) {
      Rt60Estimator estimator(read_rt60_estimator_weights(*rt60_model));
      rte_s = reverberation_error_s(estimator, pair.reference, pair.estimate);
    }
    return binaural_metrics(pair.reference, pair.estimate);
  });
  if (!metrics.lre_db) pair.notes.append("a left ear is silent, so lre_db has no value");
  if (!rt60_model)
    pair.notes.append("found no rt60.safetensors among the shipped models, so rte_s is left out");
  py::dict result;
  result["mag"] = metrics.mag;
  result["lre_db"] = metrics.lre_db;
  result["rte_s"] = rte_s;
  result["stft_distance"] = metrics.stft_distance;
  result["l2"] = metrics.l2;
  result["delay_samples"] = metrics.delay_samples;
  add_common(result, pair);
  return result;
}

py::dict rwavs(const py::array& reference, const py::array& estimate, int rate, bool sign_fix) {
  Pair pair = pair_of(reference, estimate, rate, kRwavsRateHz);
  if (sign_fix) pair.notes.append(fix_sign_of(pair));
  const RwavsMetrics metrics =
      without_lock([&] { return rwavs_metrics(pair.reference, pair.estimate); });
  py::dict result;
  result["mag"] = metrics.mag;
  result["env"] = metrics.env;
  add_common(result, pair);
  return result;
}

/// @return the JSON of `earpoint metrics --convention NAME --json`
std::string response_metrics(const py::array& reference, const py::array& estimate, int rate,
                             const std::string& convention_name, std::optional<double> length_s) {
  const MetricConvention convention = convention_named(convention_name);
  Waveform truth = waveform_of(reference, rate, "reference");
  Waveform found = waveform_of(estimate, rate, "estimate");
  return without_lock([&] {
    return json_text(json_of(response_report(convention, std::move(truth), "reference",
                                             std::move(found), "estimate", length_s)));
  });
}

}  // namespace

void bind_metrics(py::module_& module) {
  module.def("vigas_metrics", &vigas_metrics);
  module.def("rwavs_metrics", &rwavs);
  module.def("response_metrics", &response_metrics);
}

}  // namespace earpoint::python

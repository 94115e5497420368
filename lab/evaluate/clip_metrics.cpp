#include <earpoint/evaluate/clip_metrics.h>

#include "filter_fit.h"
#include "interaural_delay.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <earpoint/audio/decay.h>
#include <earpoint/audio/energy.h>
#include <earpoint/core/ears.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/evaluate/speech_metrics.h>

namespace earpoint {
namespace {

// Long enough for the first 10 dB of decay in any room; C50 lacks only what is 25 dB down.
constexpr double kResponse_s = 0.5;
// A method may render an ear earlier than the true response begins. Without taps ahead of it the
// fit would lose the direct sound. Ears are 0.7 ms apart.
constexpr double kAhead_s = 0.004;

constexpr std::array<Metric, kMetricCount> kMetrics = {Metric::mag,
                                                       Metric::lre,
                                                       Metric::rte,
                                                       Metric::level,
                                                       Metric::interaural_delay,
                                                       Metric::early_decay,
                                                       Metric::clarity,
                                                       Metric::stft_distance,
                                                       Metric::l2,
                                                       Metric::delay,
                                                       Metric::si_sdr,
                                                       Metric::estoi};

constexpr std::array<MetricName, kMetricCount> kNames = {{
    {"mag", "Mag", "", 4, "sum over the ears of the mean difference of STFT magnitudes"},
    {"lre_db", "LRE", "dB", 3, "difference of the left-right energy ratios"},
    {"rte_s", "RTE", "s", 4, "difference of RT60, estimated from the sound, mean over the ears"},
    {"level_db", "level", "dB", 3, "difference of the levels, mean over the ears"},
    {"itd_us", "ITD", "us", 1, "difference of the inter-ear delays (GCC-PHAT within 1 ms)"},
    {"edt_s", "EDT", "s", 4, "difference of the early decay times, mean over the ears"},
    {"c50_db", "C50", "dB", 3, "difference of the clarities, mean over the ears"},
    {"stft_distance", "STFT", "", 3, "sum over the ears of the Euclidean distance of the STFTs"},
    {"l2", "L2", "", 6, "mean squared difference of the samples"},
    {"delay_samples", "delay", "samples", 2, "mean delay of the ears, at most 50"},
    {"si_sdr_db", "SI-SDR", "dB", 2, "scale-invariant signal-to-distortion ratio", false},
    {"estoi", "ESTOI", "", 3, "extended short-time objective intelligibility, at most 1", false},
}};

/// Measures of the first half second of the response from the dry speech to one ear.
struct EarDecay {
  std::optional<double> early_decay_s;
  std::optional<double> clarity_db;
};

std::optional<double> defined(double (*measure)(std::span<const float>, double),
                              std::span<const float> response, double sample_rate_hz) {
  try {
    return measure(response, sample_rate_hz);
  } catch (const InputError&) {
    return std::nullopt;  // the decay is too short for this measure
  }
}

using EarDecays = std::array<EarDecay, kEars>;

/// @return the mean over the ears of the absolute differences; nothing if one is missing
std::optional<double> decay_error(const EarDecays& a, const EarDecays& b,
                                  std::optional<double> EarDecay::*measure) {
  double sum = 0.0;
  for (int ear = 0; ear < kEars; ++ear) {
    if (!(a[ear].*measure) || !(b[ear].*measure)) return std::nullopt;
    sum += std::abs(*(a[ear].*measure) - *(b[ear].*measure));
  }
  return sum / kEars;
}

std::optional<double> level_error_db(const Waveform& reference, const Waveform& estimate) {
  double sum = 0.0;
  for (int ear = 0; ear < kEars; ++ear) {
    const double a = energy(reference.channel(ear));
    const double b = energy(estimate.channel(ear));
    if (a == 0.0 || b == 0.0) return std::nullopt;
    sum += std::abs(10.0 * std::log10(b / a));
  }
  return sum / kEars;
}

}  // namespace

const MetricName& name_of(Metric metric) { return kNames.at(static_cast<std::size_t>(metric)); }

std::span<const Metric> all_metrics() { return kMetrics; }

std::span<const Metric> told_metrics() { return std::span(kMetrics).first(7); }

struct ClipMeasurer::State {
  EarDecays decays_of(const Waveform& sound) {
    EarDecays decays;
    for (int ear = 0; ear < kEars; ++ear) {
      const std::vector<float> response = fit->fit(dry, sound.channel(ear));
      decays[ear] = {defined(early_decay_time_s, response, sound.sample_rate_hz()),
                     defined(clarity_c50_db, response, sound.sample_rate_hz())};
    }
    return decays;
  }

  /// Keeps as much of the dry speech as the fitted response can reach.
  void plan_fit(const PairTruth& truth, const Waveform& sound) {
    const auto taps = static_cast<std::ptrdiff_t>(kResponse_s * sound.sample_rate_hz());
    const auto ahead = static_cast<std::ptrdiff_t>(kAhead_s * sound.sample_rate_hz());
    const std::ptrdiff_t new_lead = std::min(truth.lead, taps - 1);
    const auto speech = truth.dry.channel(0);
    EARPOINT_CHECK(std::ssize(speech) == truth.lead + sound.samples());
    dry.assign(speech.begin() + (truth.lead - new_lead), speech.end());
    if (fit && lead == new_lead && planned_samples == sound.samples()) return;
    lead = new_lead;
    planned_samples = sound.samples();
    fit.emplace(FilterShape{.before = ahead, .after = taps}, lead, planned_samples,
                FilterFit::Options{});
  }

  void judge_speech(const Waveform& rendering, ClipMetrics& metrics) {
    std::optional<double> ratio = 0.0;
    std::optional<double> intelligible = 0.0;
    for (int ear = 0; ear < kEars; ++ear) {
      const auto reference = target.channel(ear);
      const auto estimate = rendering.channel(ear);
      const auto ear_ratio = si_sdr_db(reference, estimate);
      const auto ear_intelligible = estoi.measure(reference, estimate, target.sample_rate_hz());
      ratio = ratio && ear_ratio ? std::optional(*ratio + *ear_ratio / kEars) : std::nullopt;
      intelligible = intelligible && ear_intelligible
                         ? std::optional(*intelligible + *ear_intelligible / kEars)
                         : std::nullopt;
    }
    metrics[Metric::si_sdr] = ratio;
    metrics[Metric::estoi] = intelligible;
  }

  ReverberationEstimator estimator;
  bool judges_speech = false;
  Estoi estoi;
  MetricEvaluator evaluator;
  InterauralDelay interaural;
  std::optional<FilterFit> fit;
  std::ptrdiff_t lead = 0;
  std::ptrdiff_t planned_samples = 0;

  Waveform target;
  std::vector<float> dry;  // empty if it is unknown
  std::optional<double> target_delay_s;
  std::vector<double> target_rt60_s;
  std::optional<EarDecays> target_decays;
};

ClipMeasurer::ClipMeasurer(ReverberationEstimator estimator, bool judges_speech)
    : state_(std::make_unique<State>()) {
  state_->estimator = std::move(estimator);
  state_->judges_speech = judges_speech;
}
ClipMeasurer::~ClipMeasurer() = default;
ClipMeasurer::ClipMeasurer(ClipMeasurer&&) noexcept = default;
ClipMeasurer& ClipMeasurer::operator=(ClipMeasurer&&) noexcept = default;

void ClipMeasurer::set_target(const Waveform& target, const PairTruth* truth) {
  State& s = *state_;
  check_comparable(target, "target", target, "target");
  s.target = target;
  s.target_delay_s = s.interaural.measure_s(target);
  if (s.estimator) s.target_rt60_s = s.estimator(target);
  s.target_decays.reset();
  if (truth == nullptr) return;
  s.plan_fit(*truth, target);
  s.target_decays = s.decays_of(target);
}

ClipMetrics ClipMeasurer::measure(const Waveform& rendering) {
  State& s = *state_;
  const BinauralMetrics basic = s.evaluator.measure(s.target, rendering);
  ClipMetrics metrics;
  metrics[Metric::mag] = basic.mag;
  metrics[Metric::lre] = basic.lre_db;
  metrics[Metric::stft_distance] = basic.stft_distance;
  metrics[Metric::l2] = basic.l2;
  metrics[Metric::delay] = basic.delay_samples;
  metrics[Metric::level] = level_error_db(s.target, rendering);
  const std::optional<double> delay_s = s.interaural.measure_s(rendering);
  if (delay_s && s.target_delay_s) {
    metrics[Metric::interaural_delay] = 1e6 * std::abs(*delay_s - *s.target_delay_s);
  }
  if (s.estimator) {
    const std::vector<double> rt60_s = s.estimator(rendering);
    EARPOINT_CHECK(rt60_s.size() == kEars && s.target_rt60_s.size() == kEars);
    metrics[Metric::rte] =
        (std::abs(rt60_s[0] - s.target_rt60_s[0]) + std::abs(rt60_s[1] - s.target_rt60_s[1])) /
        kEars;
  }
  if (s.judges_speech) s.judge_speech(rendering, metrics);
  if (s.target_decays) {
    const EarDecays decays = s.decays_of(rendering);
    metrics[Metric::early_decay] = decay_error(decays, *s.target_decays, &EarDecay::early_decay_s);
    metrics[Metric::clarity] = decay_error(decays, *s.target_decays, &EarDecay::clarity_db);
  }
  return metrics;
}

}  // namespace earpoint

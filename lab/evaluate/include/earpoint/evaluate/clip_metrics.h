#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <earpoint/dataset/pair_sample.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// What a rendered clip is measured by, in the order of tables. All but the last two are errors:
/// zero is best.
enum class Metric {
  mag,
  lre,
  rte,
  level,
  interaural_delay,
  early_decay,
  clarity,
  stft_distance,
  l2,
  delay,
  si_sdr,
  estoi,
};
inline constexpr std::size_t kMetricCount = 12;

struct MetricName {
  std::string_view key;      ///< in JSON, unit included: "lre_db"
  std::string_view heading;  ///< in tables: "LRE"
  std::string_view unit;     ///< "dB", or empty
  int decimals = 3;          ///< that a table shows
  std::string_view meaning;  ///< a sentence
  bool is_error = true;      ///< otherwise more is better, and a ratio to `input` says nothing
};
[[nodiscard]] const MetricName& name_of(Metric metric);

/// Every metric once.
[[nodiscard]] std::span<const Metric> all_metrics();
/// Those that tables for people show: without the distances that look at samples one by one.
[[nodiscard]] std::span<const Metric> told_metrics();

/// One clip's numbers; nothing where a metric is not defined.
class ClipMetrics {
 public:
  std::optional<double>& operator[](Metric metric) {
    return values_[static_cast<std::size_t>(metric)];
  }
  const std::optional<double>& operator[](Metric metric) const {
    return values_[static_cast<std::size_t>(metric)];
  }

 private:
  std::array<std::optional<double>, kMetricCount> values_;
};

/// Estimates the reverberation time of a sound: seconds, one per channel.
using ReverberationEstimator = std::function<std::vector<double>(const Waveform&)>;

/// Measures renderings of one target after the other:
/// - mag, lre, stft_distance, l2, delay: metrics.h;
/// - rte: mean over the ears of |RT60 - RT60'|, both estimated from the sound;
/// - level: mean over the ears of |10 log10(E' / E)|, none where an ear is silent;
/// - interaural_delay: |ITD - ITD'|, each by GCC-PHAT between the ears within 1 ms;
/// - early_decay, clarity: mean over the ears of |EDT - EDT'| and |C50 - C50'|. Both sounds are
///   first taken apart into the dry speech, which the simulator knows, and a response of half a
///   second, by the same Wiener filter, so that its faults are much the same on both sides: a
///   second of speech tells EDT to about 0.17 s in homes of 0.7 s, and C50 to 1.2 dB. None where
///   the dry speech is not known or such a response has no decay.
/// - si_sdr, estoi: speech_metrics.h, mean over the ears; only where they are asked for.
/// One object per thread.
class ClipMeasurer {
 public:
  /// @param estimator      for rte; empty: none
  /// @param judges_speech  si_sdr and estoi too: the target is speech as it should be understood
  explicit ClipMeasurer(ReverberationEstimator estimator, bool judges_speech = false);
  ~ClipMeasurer();
  ClipMeasurer(ClipMeasurer&&) noexcept;
  ClipMeasurer& operator=(ClipMeasurer&&) noexcept;

  /// Renderings are compared with this from now on.
  /// @param truth  null: not known
  /// @throws InputError if the target is not binaural or holds NaN
  void set_target(const Waveform& target, const PairTruth* truth);

  /// @throws InputError as check_comparable
  [[nodiscard]] ClipMetrics measure(const Waveform& rendering);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include <earpoint/waveform.h>

namespace earpoint {

/// The rate that the published evaluation works at; metrics at other rates mean something else.
inline constexpr int kMetricRateHz = 16000;

/// How an estimated binaural sound differs from the reference. Zero is best throughout.
struct BinauralMetrics {
  /// Sum over the ears of mean | |S| - |S'| |, S from Stft's default shape.
  double mag = 0.0;
  /// Left-right energy: | 10 log10(L / (R + 1e-5)) of the one - the same of the other |, L and R
  /// the sums of squares. No value if a left ear is silent: the ratio is then zero.
  std::optional<double> lre_db;
  /// Sum over the ears of the root of the summed | S - S' |^2.
  double stft_distance = 0.0;
  /// Mean squared difference of the samples of both ears.
  double l2 = 0.0;
  /// Mean over the ears of |delay| by GccPhat, each clamped to kMostDelaySamples. An ear that is
  /// silent on either side counts as kMostDelaySamples, as in the published evaluation. Sound
  /// longer than a minute is measured in equal parts of at most a minute, and averaged.
  double delay_samples = 0.0;
};
inline constexpr double kMostDelaySamples = 50.0;

/// Computes metrics pair after pair, keeping its plans and buffers. One object per thread.
/// Source of the definitions: Chen et al., Novel-View Acoustic Synthesis (CVPR 2023), section 5.1,
/// and what its released evaluation computes.
class MetricEvaluator {
 public:
  MetricEvaluator();
  ~MetricEvaluator();
  MetricEvaluator(MetricEvaluator&&) noexcept;
  MetricEvaluator& operator=(MetricEvaluator&&) noexcept;

  /// @param reference, estimate  binaural, of one length and rate (kMetricRateHz for published
  ///                             numbers)
  /// @throws InputError as check_comparable
  [[nodiscard]] BinauralMetrics measure(const Waveform& reference, const Waveform& estimate);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The same for one pair.
[[nodiscard]] BinauralMetrics binaural_metrics(const Waveform& reference, const Waveform& estimate);

/// The rate of the RWAVS benchmark.
inline constexpr int kRwavsRateHz = 22050;

/// The metrics of the RWAVS benchmark, at kRwavsRateHz (both sounds are resampled to it).
struct RwavsMetrics {
  /// Sum over the ears of mean (|S| - |S'|)^2, S with 512 points, hop 128, periodic Hann window,
  /// zeros outside.
  double mag = 0.0;
  /// Sum over the ears of the root-mean-square difference of the Hilbert envelopes.
  double env = 0.0;
};

/// @param reference, estimate  binaural, of one length and rate
/// @throws InputError as check_comparable
/// Source: Liang et al., AV-NeRF (NeurIPS 2023) and its released evaluation. That one scales every
/// scene to a peak of 1 first; here the samples count as they are.
[[nodiscard]] RwavsMetrics rwavs_metrics(const Waveform& reference, const Waveform& estimate);

/// What the sign fix did to the estimates.
enum class SignFix { none, negated_left, negated_right };

/// The published evaluation's repair of estimates whose ears are in opposite phase: if the sum of
/// left * right over the whole batch is negative, one ear of every estimate is negated; the right
/// one if the left ears agree with the references' (sum of products > 0), otherwise the left one.
/// It looks at the reference, so numbers with it flatter; it is never applied by the metrics.
/// @param estimates   binaural, changed in place
/// @param references  as many, of the same lengths
SignFix fix_sign(std::span<Waveform> estimates, std::span<const Waveform> references);

/// Refuses what metrics cannot compare: not two channels, no samples, samples that are not finite,
/// different rates or lengths.
/// @param reference_name, estimate_name  stand for the two in messages, e.g. their files
/// @throws InputError
void check_comparable(const Waveform& reference, std::string_view reference_name,
                      const Waveform& estimate, std::string_view estimate_name);

}  // namespace earpoint

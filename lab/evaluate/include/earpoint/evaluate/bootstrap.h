#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace earpoint {

/// Where a number would lie in most repetitions of an experiment.
struct ConfidenceRange {
  double low = 0.0;
  double high = 0.0;
};

/// A number over clips, and how sure it is.
struct Estimate {
  double value = 0.0;
  /// Nothing if all clips are of one cluster.
  std::optional<ConfidenceRange> range;
  std::size_t clips = 0;  ///< clips with a value
};

/// Means over clips with bootstrap intervals. Clips that belong together (the windows and
/// viewpoints of one conversation share room, voices and positions) are not independent draws, so
/// what is drawn with replacement are their clusters, whole. All numbers of one object use the same
/// draws; the ratio of two methods is thereby a paired comparison, narrower than its parts.
///
/// Percentile interval. Source: Efron and Tibshirani, An Introduction to the Bootstrap (1993),
/// chapters 8 and 13; Davison and Hinkley, Bootstrap Methods (1997), 3.8, for clusters.
class ClusterBootstrap {
 public:
  struct Options {
    int replicates = 4000;
    std::uint64_t seed = 1;
    double confidence = 0.95;
  };

  /// @param cluster_of_clip  any number per clip; clips with the same one belong together
  explicit ClusterBootstrap(std::span<const int> cluster_of_clip);
  ClusterBootstrap(std::span<const int> cluster_of_clip, Options options);

  /// @param values  one per clip; clips without one are left out
  /// @return nothing if no clip has a value
  [[nodiscard]] std::optional<Estimate> mean(std::span<const std::optional<double>> values) const;

  /// Mean of `values` over mean of `baseline`, over the clips that have both.
  /// @return nothing if no clip has both, or the baseline's mean is zero
  [[nodiscard]] std::optional<Estimate> ratio(
      std::span<const std::optional<double>> values,
      std::span<const std::optional<double>> baseline) const;

  [[nodiscard]] std::size_t clusters() const { return clusters_; }

 private:
  struct Sums;  // per cluster: of the values, of the baseline
  [[nodiscard]] std::optional<Estimate> estimate(const Sums& sums) const;

  Options options_;
  std::vector<std::size_t> cluster_of_clip_;  // from 0, without gaps
  std::size_t clusters_ = 0;
  std::vector<std::uint16_t> draws_;  // [replicate][cluster]: how often it was drawn
};

/// Means over answers that were given by several participants to the same clips. Answers of one
/// participant belong together, and so do answers to one clip; drawn with replacement are therefore
/// participants and, independently, clips, and an answer counts as often as both were drawn. The
/// intervals are a little wider than the truth where answers are independent of one of the two.
///
/// Percentile interval. Source: Owen, The pigeonhole bootstrap, Annals of Applied Statistics 1
/// (2007).
class CrossedBootstrap {
 public:
  using Options = ClusterBootstrap::Options;

  /// @param participant_of_answer, clip_of_answer  any numbers, one of each per answer
  CrossedBootstrap(std::span<const int> participant_of_answer, std::span<const int> clip_of_answer);
  CrossedBootstrap(std::span<const int> participant_of_answer, std::span<const int> clip_of_answer,
                   Options options);

  /// @param values  one per answer; answers without one are left out
  /// @return nothing if no answer has a value; without a range if the values are of one participant
  ///         or of one clip only
  [[nodiscard]] std::optional<Estimate> mean(std::span<const std::optional<double>> values) const;

 private:
  Options options_;
  std::vector<std::size_t> participants_;  // of answers, from 0, without gaps
  std::vector<std::size_t> clips_;         // likewise
  std::vector<std::uint16_t>
      participant_draws_;                  // [replicate][participant]: how often it was drawn
  std::vector<std::uint16_t> clip_draws_;  // [replicate][clip]
};

}  // namespace earpoint

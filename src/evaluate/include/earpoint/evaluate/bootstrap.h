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
  /// Nothing where there are clips of one cluster only: they cannot tell.
  std::optional<ConfidenceRange> range;
  std::size_t clips = 0;  ///< that it is over
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

}  // namespace earpoint

#include <algorithm>
#include <cmath>
#include <map>

#include <earpoint/core/error.h>
#include <earpoint/core/random.h>
#include <earpoint/evaluate/bootstrap.h>

namespace earpoint {

/// A mean is the ratio of a sum to a count, so one form serves both.
struct ClusterBootstrap::Sums {
  explicit Sums(std::size_t clusters) : above(clusters), below(clusters) {}
  std::vector<double> above;
  std::vector<double> below;
  std::size_t clips = 0;
};

namespace {

/// Linear between the order statistics. @param sorted  not empty
double quantile(const std::vector<double>& sorted, double probability) {
  const double place = probability * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

ClusterBootstrap::ClusterBootstrap(std::span<const int> cluster_of_clip)
    : ClusterBootstrap(cluster_of_clip, Options{}) {}

ClusterBootstrap::ClusterBootstrap(std::span<const int> cluster_of_clip, Options options)
    : options_(options) {
  EARPOINT_CHECK(options.replicates > 0);
  EARPOINT_CHECK(options.confidence > 0.0 && options.confidence < 1.0);
  std::map<int, std::size_t> numbers;
  for (const int cluster : cluster_of_clip) {
    cluster_of_clip_.push_back(numbers.try_emplace(cluster, numbers.size()).first->second);
  }
  clusters_ = numbers.size();
  RandomStream random(options.seed);
  draws_.assign(clusters_ * static_cast<std::size_t>(options.replicates), 0);
  for (std::size_t start = 0; start < draws_.size(); start += clusters_) {
    for (std::size_t i = 0; i < clusters_; ++i) ++draws_[start + random.index(clusters_)];
  }
}

std::optional<Estimate> ClusterBootstrap::mean(
    std::span<const std::optional<double>> values) const {
  EARPOINT_CHECK(values.size() == cluster_of_clip_.size());
  Sums sums(clusters_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i]) continue;
    sums.above[cluster_of_clip_[i]] += *values[i];
    sums.below[cluster_of_clip_[i]] += 1.0;
    ++sums.clips;
  }
  return estimate(sums);
}

std::optional<Estimate> ClusterBootstrap::ratio(
    std::span<const std::optional<double>> values,
    std::span<const std::optional<double>> baseline) const {
  EARPOINT_CHECK(values.size() == cluster_of_clip_.size() && baseline.size() == values.size());
  Sums sums(clusters_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i] || !baseline[i]) continue;
    sums.above[cluster_of_clip_[i]] += *values[i];
    sums.below[cluster_of_clip_[i]] += *baseline[i];
    ++sums.clips;
  }
  return estimate(sums);
}

std::optional<Estimate> ClusterBootstrap::estimate(const Sums& sums) const {
  double above = 0.0;
  double below = 0.0;
  std::size_t with_values = 0;
  for (std::size_t c = 0; c < clusters_; ++c) {
    above += sums.above[c];
    below += sums.below[c];
    if (sums.below[c] != 0.0) ++with_values;
  }
  if (sums.clips == 0 || below == 0.0) return std::nullopt;
  Estimate result{.value = above / below, .range = std::nullopt, .clips = sums.clips};
  if (with_values < 2) return result;

  std::vector<double> replicates;
  for (std::size_t start = 0; start < draws_.size(); start += clusters_) {
    double drawn_above = 0.0;
    double drawn_below = 0.0;
    for (std::size_t c = 0; c < clusters_; ++c) {
      drawn_above += draws_[start + c] * sums.above[c];
      drawn_below += draws_[start + c] * sums.below[c];
    }
    // Only clusters without a value were drawn: this replicate says nothing.
    if (drawn_below != 0.0) replicates.push_back(drawn_above / drawn_below);
  }
  std::ranges::sort(replicates);
  const double tail = (1.0 - options_.confidence) / 2.0;
  result.range = ConfidenceRange{quantile(replicates, tail), quantile(replicates, 1.0 - tail)};
  return result;
}

}  // namespace earpoint

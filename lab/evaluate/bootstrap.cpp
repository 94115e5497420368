#include <earpoint/evaluate/bootstrap.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <earpoint/core/random.h>
#include <earpoint/error.h>

namespace earpoint {

/// Numerator and denominator by cluster. A mean is the ratio of a sum to a count.
struct ClusterBootstrap::Sums {
  explicit Sums(std::size_t clusters) : above(clusters), below(clusters) {}
  std::vector<double> above;
  std::vector<double> below;
  std::size_t clips = 0;
};

namespace {

/// Interpolated linearly between the order statistics. @param sorted  not empty
double quantile(const std::vector<double>& sorted, double probability) {
  const double place = probability * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

/// Numbers the clusters from 0 in the order in which they appear.
std::vector<std::size_t> numbered(std::span<const int> clusters) {
  std::map<int, std::size_t> numbers;
  std::vector<std::size_t> result;
  for (const int cluster : clusters) {
    result.push_back(numbers.try_emplace(cluster, numbers.size()).first->second);
  }
  return result;
}

/// How often each of `count` clusters is drawn, [replicate][cluster].
std::vector<std::uint16_t> draw(std::size_t count, int replicates, RandomStream& random) {
  std::vector<std::uint16_t> draws(count * static_cast<std::size_t>(replicates), 0);
  for (std::size_t start = 0; start < draws.size(); start += count) {
    for (std::size_t i = 0; i < count; ++i) ++draws[start + random.index(count)];
  }
  return draws;
}

std::size_t clusters_in(std::span<const std::size_t> numbers) {
  return numbers.empty() ? 0 : *std::ranges::max_element(numbers) + 1;
}

/// @param replicates  not empty
ConfidenceRange percentile_range(std::vector<double> replicates, double confidence) {
  std::ranges::sort(replicates);
  const double tail = (1.0 - confidence) / 2.0;
  return {quantile(replicates, tail), quantile(replicates, 1.0 - tail)};
}

}  // namespace

ClusterBootstrap::ClusterBootstrap(std::span<const int> cluster_of_clip)
    : ClusterBootstrap(cluster_of_clip, Options{}) {}

ClusterBootstrap::ClusterBootstrap(std::span<const int> cluster_of_clip, Options options)
    : options_(options) {
  EARPOINT_CHECK(options.replicates > 0);
  EARPOINT_CHECK(options.confidence > 0.0 && options.confidence < 1.0);
  cluster_of_clip_ = numbered(cluster_of_clip);
  clusters_ = clusters_in(cluster_of_clip_);
  RandomStream random(options.seed);
  draws_ = draw(clusters_, options.replicates, random);
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
    // A replicate of clusters without values has no mean.
    if (drawn_below != 0.0) replicates.push_back(drawn_above / drawn_below);
  }
  result.range = percentile_range(std::move(replicates), options_.confidence);
  return result;
}

CrossedBootstrap::CrossedBootstrap(std::span<const int> participant_of_answer,
                                   std::span<const int> clip_of_answer)
    : CrossedBootstrap(participant_of_answer, clip_of_answer, Options{}) {}

CrossedBootstrap::CrossedBootstrap(std::span<const int> participant_of_answer,
                                   std::span<const int> clip_of_answer, Options options)
    : options_(options),
      participants_(numbered(participant_of_answer)),
      clips_(numbered(clip_of_answer)) {
  EARPOINT_CHECK(participant_of_answer.size() == clip_of_answer.size());
  EARPOINT_CHECK(options.replicates > 0);
  EARPOINT_CHECK(options.confidence > 0.0 && options.confidence < 1.0);
  RandomStream random(options.seed);
  participant_draws_ = draw(clusters_in(participants_), options.replicates, random);
  clip_draws_ = draw(clusters_in(clips_), options.replicates, random);
}

std::optional<Estimate> CrossedBootstrap::mean(
    std::span<const std::optional<double>> values) const {
  EARPOINT_CHECK(values.size() == participants_.size());
  const std::size_t participants = clusters_in(participants_);
  const std::size_t clips = clusters_in(clips_);
  Estimate result;
  std::set<std::size_t> participants_with_values;
  std::set<std::size_t> clips_with_values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i]) continue;
    result.value += *values[i];
    ++result.clips;
    participants_with_values.insert(participants_[i]);
    clips_with_values.insert(clips_[i]);
  }
  if (result.clips == 0) return std::nullopt;
  result.value /= static_cast<double>(result.clips);
  if (participants_with_values.size() < 2 || clips_with_values.size() < 2) return result;

  std::vector<double> replicates;
  for (std::size_t r = 0; r < static_cast<std::size_t>(options_.replicates); ++r) {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!values[i]) continue;
      const double times = participant_draws_[r * participants + participants_[i]] *
                           clip_draws_[r * clips + clips_[i]];
      sum += times * *values[i];
      count += times;
    }
    if (count > 0.0) replicates.push_back(sum / count);
  }
  result.range = percentile_range(std::move(replicates), options_.confidence);
  return result;
}

}  // namespace earpoint

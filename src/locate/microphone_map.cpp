#include <earpoint/locate/microphone_map.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <earpoint/error.h>
#include <earpoint/locate/assignment.h>

namespace earpoint {
namespace {

using Costs = std::vector<std::vector<double>>;

// If the loudest near-range microphone leads by this much, its wearer speaks alone.
constexpr double kClearlyLoudest_db = 6.0;
// Standard deviation of a moment's level at the camera that distance does not explain (rooms, the
// speaker's heading), and of the microphones' gains.
constexpr double kUnexplained_db = 4.0;
constexpr double kGainSpread_db = 3.0;
// Errors of neighbouring moments are correlated: each moment counts as this many independent ones.
constexpr double kIndependentShare = 0.25;
// Limits the influence of any single moment.
constexpr double kLargestError_db = 12.0;

/// How well one microphone's moments fit one person.
struct Match {
  double gain_db = 0.0;  ///< that fits best
  double cost = 0.0;     ///< negative log likelihood with it, up to a constant
  double weight = 0.0;   ///< number of independent moments
};

struct Turn {
  std::size_t microphone;
  const NearRangeMoment* moment;
};

std::vector<Turn> turns_of(std::span<const NearRangeMoment> moments, double silence_db) {
  std::vector<Turn> turns;
  for (const NearRangeMoment& moment : moments) {
    EARPOINT_CHECK(moment.near_db.size() == moments.front().near_db.size());
    EARPOINT_CHECK(moment.distance_m.size() == moments.front().distance_m.size());
    EARPOINT_CHECK(moment.direction_log_likelihood.empty() ||
                   moment.direction_log_likelihood.size() == moment.distance_m.size());
    const auto loudest = loudest_microphone(moment.near_db, silence_db);
    if (!loudest) continue;
    const bool is_clear = std::ranges::count_if(moment.near_db, [&](double level) {
                            return level > moment.near_db[*loudest] - kClearlyLoudest_db;
                          }) == 1;
    if (is_clear) turns.push_back({*loudest, &moment});
  }
  return turns;
}

/// Logarithm of the mean likelihood of all people; it stands for somebody who is not seen.
double mean_log_likelihood(const NearRangeMoment& moment) {
  const std::vector<double>& logs = moment.direction_log_likelihood;
  const double largest = *std::ranges::max_element(logs);
  double sum = 0.0;
  for (const double value : logs) sum += std::exp(value - largest);
  return largest + std::log(sum / static_cast<double>(logs.size()));
}

Match match_of(const std::vector<Turn>& turns, std::size_t microphone, std::size_t person) {
  std::vector<double> gains;
  Match match;
  for (const Turn& turn : turns) {
    if (turn.microphone != microphone) continue;
    const NearRangeMoment& moment = *turn.moment;
    if (!moment.direction_log_likelihood.empty()) {
      // Somebody who is not seen may speak outside the picture: no evidence either way.
      const double seen = moment.distance_m[person] ? moment.direction_log_likelihood[person]
                                                    : mean_log_likelihood(moment);
      match.cost -= kIndependentShare * (seen - mean_log_likelihood(moment));
    }
    if (!moment.distance_m[person]) continue;
    gains.push_back(moment.near_db[microphone] - moment.camera_db -
                    20.0 * std::log10(std::max(*moment.distance_m[person], 0.1)));
  }
  if (gains.empty()) return match;
  std::vector<double> sorted = gains;
  std::ranges::sort(sorted);
  match.gain_db = sorted[sorted.size() / 2];
  match.weight = kIndependentShare * static_cast<double>(gains.size());
  for (const double gain : gains) {
    const double error = std::min(std::abs(gain - match.gain_db), kLargestError_db);
    match.cost += kIndependentShare * 0.5 * std::pow(error / kUnexplained_db, 2);
  }
  return match;
}

/// The costs if `gain_db` were the mean gain of the microphones.
Costs costs_for(const std::vector<std::vector<Match>>& matches, double gain_db) {
  Costs costs;
  for (const std::vector<Match>& row : matches) {
    costs.emplace_back();
    for (const Match& match : row) {
      const double variance =
          std::pow(kGainSpread_db, 2) + std::pow(kUnexplained_db, 2) / std::max(match.weight, 1e-9);
      costs.back().push_back(match.cost + 0.5 * std::pow(match.gain_db - gain_db, 2) / variance);
    }
  }
  return costs;
}

double sum_of(const Costs& costs, const std::vector<std::optional<std::size_t>>& pairs) {
  double sum = 0.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i]) sum += costs[i][*pairs[i]];
  }
  return sum;
}

}  // namespace

std::optional<std::size_t> loudest_microphone(std::span<const double> near_db, double silence_db) {
  const auto loudest = std::ranges::max_element(near_db);
  if (loudest == near_db.end() || *loudest <= silence_db) return std::nullopt;
  return static_cast<std::size_t>(loudest - near_db.begin());
}

MicrophoneMap match_microphones(std::span<const NearRangeMoment> moments, double silence_db) {
  MicrophoneMap map;
  if (moments.empty()) return map;
  const std::vector<Turn> turns = turns_of(moments, silence_db);
  const std::size_t microphones = moments.front().near_db.size();
  const std::size_t people = moments.front().distance_m.size();
  std::vector<std::vector<Match>> matches(microphones);
  for (std::size_t m = 0; m < microphones; ++m) {
    for (std::size_t p = 0; p < people; ++p) matches[m].push_back(match_of(turns, m, p));
  }
  // The mean gain is not known: try the best gain of every pair.
  Costs best;
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<Match>& row : matches) {
    for (const Match& match : row) {
      const Costs costs = costs_for(matches, match.gain_db);
      const double sum = sum_of(costs, cheapest_pairs(costs));
      if (sum >= least) continue;
      least = sum;
      best = costs;
    }
  }
  map.certainty.assign(microphones, 0.0);
  map.person_of.assign(microphones, std::nullopt);
  if (best.empty()) return map;
  map.person_of = cheapest_pairs(best);
  for (std::size_t m = 0; m < microphones; ++m) {
    if (!map.person_of[m]) continue;
    // How much the total cost rises if this microphone is somebody else's.
    Costs without = best;
    without[m][*map.person_of[m]] = 1e6;
    const double other = sum_of(without, cheapest_pairs(without));
    map.certainty[m] = 1.0 / (1.0 + std::exp(-std::max(other - least, 0.0)));
  }
  return map;
}

}  // namespace earpoint

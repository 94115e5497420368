#include "source_walk.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace earpoint {
namespace {

// The rays of a source are traced in this number of shares, independent of the number of threads,
// and added in order, so that the sum does not depend on timing.
constexpr int kShares = 8;

constexpr int kLeastSurvey = 100;  // rays
constexpr int kSurveyShare = 10;   // one ray for so many that are walked

void add(const WalkTally& tally, WalkTally& total) {
  total.emitted += tally.emitted;
  total.escaped += tally.escaped;
  total.rays_cast += tally.rays_cast;
  for (std::size_t i = 0; i < total.late.size(); ++i) total.late[i].add(tally.late[i]);
  for (std::size_t i = 0; i < total.alive.size(); ++i) {
    total.alive_squares[i] += tally.alive_squares[i];
    for (int band = 0; band < kOctaveBands; ++band) total.alive[i][band] += tally.alive[i][band];
  }
}

// Traces the shares and adds those of each source in order.
// @param expected  [source], or empty for a first survey
// @param pass      each draws its own random numbers
std::vector<WalkTally> walk_shares(const WalkSetup& setup, std::span<const Source> sources,
                                   std::span<const EnergyAlive> expected, std::uint64_t pass,
                                   ThreadPool& pool) {
  const std::int64_t rays = setup.rays;
  std::vector<WalkTally> shares(sources.size() * kShares);
  pool.run(std::ssize(shares), [&](std::ptrdiff_t task, int) {
    const auto source = static_cast<std::size_t>(task / kShares);
    const std::int64_t share = task % kShares;
    WalkTask walk{.source = &sources[source],
                  .stream = source + (pass << 32U),
                  .first_ray = static_cast<int>(share * rays / kShares),
                  .last_ray = static_cast<int>((share + 1) * rays / kShares)};
    if (!expected.empty()) walk.expected = &expected[source];
    shares[task] = walk_rays(setup, walk);
  });
  std::vector<WalkTally> totals;
  for (std::size_t source = 0; source < sources.size(); ++source) {
    totals.push_back(std::move(shares[source * kShares]));
    for (int share = 1; share < kShares; ++share) {
      add(shares[source * kShares + share], totals.back());
    }
  }
  return totals;
}

// The survey's energies while there are enough rays; from there on they decay at the same rate. Too
// low an estimate would split rays without end.
EnergyAlive expected_energies(WalkTally survey) {
  constexpr double kEnoughRays = 20.0;
  EnergyAlive energies = std::move(survey.alive);
  std::size_t known = 0;
  while (known + 1 < energies.size()) {
    double sum = 0.0;
    for (const float band : energies[known + 1]) sum += static_cast<double>(band);
    // This number of rays of equal energy would have the same sum and sum of squares.
    if (sum * sum < kEnoughRays * survey.alive_squares[known + 1]) break;
    ++known;
  }
  const std::size_t from = known / 2;
  for (int band = 0; band < kOctaveBands; ++band) {
    const float before = energies[from][band];
    const float last = energies[known][band];
    const float step =
        known > from && before > 0.0F
            ? std::min(1.0F, std::pow(last / before, 1.0F / static_cast<float>(known - from)))
            : 1.0F;
    for (std::size_t i = known + 1; i < energies.size(); ++i) {
      energies[i][band] = step * energies[i - 1][band];
    }
  }
  return energies;
}

}  // namespace

std::vector<WalkTally> walk_sources(const WalkSetup& setup, std::span<const Source> sources,
                                    ThreadPool& pool) {
  WalkSetup survey = setup;
  survey.listeners = {};
  survey.survey = true;
  survey.rays = std::max(std::min(setup.rays, kLeastSurvey), setup.rays / kSurveyShare);
  std::vector<EnergyAlive> expected;
  std::int64_t rays_cast = 0;
  // The first survey loses slowly decaying energy; the second, guided by the first, does not.
  for (const std::uint64_t pass : {1U, 2U}) {
    std::vector<EnergyAlive> found;
    for (WalkTally& tally : walk_shares(survey, sources, expected, pass, pool)) {
      rays_cast += tally.rays_cast;
      found.push_back(expected_energies(std::move(tally)));
    }
    expected = std::move(found);
  }
  std::vector<WalkTally> tallies = walk_shares(setup, sources, expected, 0, pool);
  if (!tallies.empty()) tallies.front().rays_cast += rays_cast;
  return tallies;
}

}  // namespace earpoint

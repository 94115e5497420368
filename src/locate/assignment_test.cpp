#include <algorithm>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/locate/assignment.h>

namespace earpoint {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

TEST(CheapestPairs, AreAsCheapAsTheBestOfAllPermutations) {
  RandomStream random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<std::vector<double>> costs(5, std::vector<double>(5));
    for (auto& row : costs) {
      for (double& cost : row) cost = random.uniform(-1.0, 1.0);
    }
    std::vector<std::size_t> order(5);
    std::iota(order.begin(), order.end(), 0U);
    double best = kNever;
    do {
      double sum = 0.0;
      for (std::size_t i = 0; i < 5; ++i) sum += costs[i][order[i]];
      best = std::min(best, sum);
    } while (std::ranges::next_permutation(order).found);
    double found = 0.0;
    const auto pairs = cheapest_pairs(costs);
    for (std::size_t i = 0; i < 5; ++i) found += costs[i][pairs[i].value()];
    EXPECT_NEAR(found, best, 1e-12);  // rounding of sums of five
  }
}

TEST(CheapestPairs, LeaveOutWhatMustNotBeAndPairTheRest) {
  // The first row prefers column 0, which is the only one that the second row may have.
  const auto pairs = cheapest_pairs({{0.0, 5.0, kNever}, {0.1, kNever, kNever}});
  EXPECT_EQ(pairs[0], 1U);
  EXPECT_EQ(pairs[1], 0U);
  EXPECT_EQ(cheapest_pairs({{kNever}})[0], std::nullopt);
  EXPECT_EQ(cheapest_pairs({{}, {}}).size(), 2U);
  EXPECT_EQ(cheapest_pairs({{2.0}, {1.0}, {3.0}})[1], 0U);
}

}  // namespace
}  // namespace earpoint

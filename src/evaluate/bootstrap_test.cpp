#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/evaluate/bootstrap.h>

namespace earpoint {
namespace {

using Values = std::vector<std::optional<double>>;

std::vector<int> every_clip_for_itself(std::size_t clips) {
  std::vector<int> clusters(clips);
  std::iota(clusters.begin(), clusters.end(), 0);
  return clusters;
}

TEST(ClusterBootstrap, IntervalOfAShareIsTheBinomials) {
  // 30 ones among 100: a replicate is Binomial(100, 0.3) / 100, whose 2.5 % and 97.5 % quantiles
  // are 0.21 and 0.39.
  Values values(100, 0.0);
  for (std::size_t i = 0; i < 30; ++i) values[i] = 1.0;
  const ClusterBootstrap bootstrap(every_clip_for_itself(100), {.replicates = 20000});
  const Estimate share = bootstrap.mean(values).value();
  EXPECT_DOUBLE_EQ(share.value, 0.3);
  EXPECT_EQ(share.clips, 100U);
  // One step of the discrete distribution: 20000 draws put a quantile no farther off.
  EXPECT_NEAR(share.range->low, 0.21, 0.0101);
  EXPECT_NEAR(share.range->high, 0.39, 0.0101);
}

TEST(ClusterBootstrap, IntervalOfAMeanFollowsTheStandardError) {
  RandomStream random(5);
  Values values;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < 400; ++i) {
    const double x = random.normal();
    values.emplace_back(x);
    sum += x;
    squares += x * x;
  }
  const double mean = sum / 400;
  const double error = std::sqrt((squares / 400 - mean * mean) / 400);
  const ClusterBootstrap bootstrap(every_clip_for_itself(400), {.replicates = 20000});
  const ConfidenceRange range = bootstrap.mean(values)->range.value();
  // The quantiles of 20000 replicates scatter by 2 % of the standard error.
  EXPECT_NEAR(range.low, mean - 1.96 * error, 0.08 * error);
  EXPECT_NEAR(range.high, mean + 1.96 * error, 0.08 * error);
}

TEST(ClusterBootstrap, CopiesWithinAClusterAddNoCertainty) {
  RandomStream random(6);
  Values single;
  Values copies;
  std::vector<int> clusters;
  for (int i = 0; i < 50; ++i) {
    single.emplace_back(random.uniform());
    for (int k = 0; k < 12; ++k) {
      copies.push_back(single.back());
      clusters.push_back(1000 - i);
    }
  }
  const Estimate one = ClusterBootstrap(every_clip_for_itself(50)).mean(single).value();
  const Estimate twelve = ClusterBootstrap(clusters).mean(copies).value();
  EXPECT_EQ(ClusterBootstrap(clusters).clusters(), 50U);
  // The same draws of the same clusters; only the order of summation differs.
  EXPECT_NEAR(one.value, twelve.value, 1e-12);
  EXPECT_NEAR(one.range->low, twelve.range->low, 1e-12);
  EXPECT_NEAR(one.range->high, twelve.range->high, 1e-12);
  const Estimate naive = ClusterBootstrap(every_clip_for_itself(600)).mean(copies).value();
  EXPECT_LT(naive.range->high - naive.range->low, 0.4 * (one.range->high - one.range->low));
}

TEST(ClusterBootstrap, RatioIsPaired) {
  // Twice the baseline in every clip: however the clips scatter, the ratio does not.
  RandomStream random(7);
  Values baseline;
  Values twice;
  for (int i = 0; i < 30; ++i) {
    baseline.emplace_back(random.uniform(0.1, 10.0));
    twice.emplace_back(2.0 * *baseline.back());
  }
  const ClusterBootstrap bootstrap(every_clip_for_itself(30));
  const Estimate ratio = bootstrap.ratio(twice, baseline).value();
  EXPECT_NEAR(ratio.value, 2.0, 1e-12);
  EXPECT_NEAR(ratio.range->low, 2.0, 1e-12);
  EXPECT_NEAR(ratio.range->high, 2.0, 1e-12);
}

TEST(ClusterBootstrap, ClipsWithoutAValueAreLeftOut) {
  const ClusterBootstrap bootstrap(every_clip_for_itself(4));
  const Estimate mean = bootstrap.mean(Values{1.0, std::nullopt, 3.0, std::nullopt}).value();
  EXPECT_DOUBLE_EQ(mean.value, 2.0);
  EXPECT_EQ(mean.clips, 2U);
  const Estimate ratio =
      bootstrap.ratio(Values{1.0, 5.0, 3.0, std::nullopt}, Values{4.0, std::nullopt, 4.0, 1.0})
          .value();
  EXPECT_DOUBLE_EQ(ratio.value, 0.5);
  EXPECT_FALSE(bootstrap.mean(Values(4, std::nullopt)).has_value());
  EXPECT_FALSE(bootstrap.ratio(Values(4, 1.0), Values(4, 0.0)).has_value());
}

TEST(ClusterBootstrap, OneClusterHasAMeanAndNoInterval) {
  const std::vector<int> clusters(3, 9);
  const Estimate mean = ClusterBootstrap(clusters).mean(Values{1.0, 2.0, 6.0}).value();
  EXPECT_DOUBLE_EQ(mean.value, 3.0);
  EXPECT_FALSE(mean.range.has_value());
}

TEST(ClusterBootstrap, SameSeedSameInterval) {
  Values values;
  RandomStream random(8);
  for (int i = 0; i < 20; ++i) values.emplace_back(random.uniform());
  const std::vector<int> clusters = every_clip_for_itself(20);
  const auto low = [&](std::uint64_t seed) {
    return ClusterBootstrap(clusters, {.replicates = 500, .seed = seed}).mean(values)->range->low;
  };
  EXPECT_EQ(low(3), low(3));
  EXPECT_NE(low(3), low(4));
}

}  // namespace
}  // namespace earpoint

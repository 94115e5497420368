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
  // One step of the discrete distribution: with 20000 draws a quantile is off by no more.
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
  // The quantiles of 20000 replicates vary by 2 % of the standard error; four times that.
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
  // The same clusters are drawn; only the order of summation differs.
  EXPECT_NEAR(one.value, twelve.value, 1e-12);
  EXPECT_NEAR(one.range->low, twelve.range->low, 1e-12);
  EXPECT_NEAR(one.range->high, twelve.range->high, 1e-12);
  const Estimate naive = ClusterBootstrap(every_clip_for_itself(600)).mean(copies).value();
  EXPECT_LT(naive.range->high - naive.range->low, 0.4 * (one.range->high - one.range->low));
}

TEST(ClusterBootstrap, RatioIsPaired) {
  // Twice the baseline in every clip: the ratio is the same however much the clips vary.
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

/// Answers of every participant to every clip, with effects of participant, clip and noise.
struct Answers {
  Values values;
  std::vector<int> participants;
  std::vector<int> clips;
};

Answers crossed_answers(int participants, int clips, double participant_scale, double clip_scale,
                        double chance_scale, RandomStream& random) {
  std::vector<double> clip_effects;
  for (int c = 0; c < clips; ++c) clip_effects.push_back(clip_scale * random.normal());
  Answers answers;
  for (int p = 0; p < participants; ++p) {
    const double effect = participant_scale * random.normal();
    for (int c = 0; c < clips; ++c) {
      answers.values.emplace_back(effect + clip_effects[c] + chance_scale * random.normal());
      answers.participants.push_back(100 + 7 * p);
      answers.clips.push_back(c);
    }
  }
  return answers;
}

TEST(CrossedBootstrap, CoversTheTruthWhereParticipantsAndClipsDiffer) {
  // At best 95 % of experiments; percentile intervals of 20 by 20 groups cover a few percent less.
  // Intervals by clip alone are narrower by a factor of 0.71 and cover 83 %.
  constexpr int kExperiments = 300;
  RandomStream random(11);
  int covered = 0;
  int covered_by_clips_alone = 0;
  for (int e = 0; e < kExperiments; ++e) {
    const Answers answers = crossed_answers(20, 20, 1.0, 1.0, 1.0, random);
    const CrossedBootstrap bootstrap(answers.participants, answers.clips, {.replicates = 400});
    const ConfidenceRange range = bootstrap.mean(answers.values)->range.value();
    if (range.low < 0.0 && range.high > 0.0) ++covered;
    const ClusterBootstrap one_way(answers.clips, {.replicates = 400});
    const ConfidenceRange narrow = one_way.mean(answers.values)->range.value();
    if (narrow.low < 0.0 && narrow.high > 0.0) ++covered_by_clips_alone;
  }
  // A share of 0.95 of 300 has a standard error of 0.0126.
  EXPECT_GT(covered, static_cast<int>(0.90 * kExperiments));
  EXPECT_LT(covered_by_clips_alone, static_cast<int>(0.89 * kExperiments));
}

TEST(CrossedBootstrap, ParticipantsWhoAnswerAlikeAddNoCertaintyAboutClips) {
  // 40 participants agree on every clip: the interval is that of the clips, as if one had answered.
  RandomStream random(12);
  const Answers answers = crossed_answers(40, 25, 0.0, 1.0, 0.0, random);
  const CrossedBootstrap crossed(answers.participants, answers.clips, {.replicates = 20000});
  const ClusterBootstrap by_clip(answers.clips, {.replicates = 20000});
  const ConfidenceRange both = crossed.mean(answers.values)->range.value();
  const ConfidenceRange clips = by_clip.mean(answers.values)->range.value();
  const double width = clips.high - clips.low;
  // Quantiles of 20000 replicates have a standard error of about 1 % of the width.
  EXPECT_NEAR(both.low, clips.low, 0.03 * width);
  EXPECT_NEAR(both.high, clips.high, 0.03 * width);
}

TEST(CrossedBootstrap, OneParticipantOrOneClipHasNoInterval) {
  const std::vector<int> ones{1, 1, 1};
  const std::vector<int> numbers{1, 2, 3};
  const Values values{1.0, 0.0, 1.0};
  const Estimate alone = CrossedBootstrap(ones, numbers).mean(values).value();
  EXPECT_DOUBLE_EQ(alone.value, 2.0 / 3.0);
  EXPECT_FALSE(alone.range);
  EXPECT_FALSE(CrossedBootstrap(numbers, ones).mean(values)->range);
  EXPECT_FALSE(CrossedBootstrap(numbers, numbers).mean(Values(3)));
}

}  // namespace
}  // namespace earpoint

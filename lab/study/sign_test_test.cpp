#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/study/sign_test.h>

namespace earpoint {
namespace {

// Sums of some hundred terms in double precision.
constexpr double kRounding = 1e-9;

TEST(SignTest, IsTheBinomialDistribution) {
  EXPECT_NEAR(sign_test_p(5, 0), 2.0 / 32.0, kRounding);
  EXPECT_NEAR(sign_test_p(0, 5), 2.0 / 32.0, kRounding);
  EXPECT_NEAR(sign_test_p(8, 2), 2.0 * (1 + 10 + 45) / 1024.0, kRounding);
  EXPECT_DOUBLE_EQ(sign_test_p(4, 4), 1.0);
  EXPECT_DOUBLE_EQ(sign_test_p(0, 0), 1.0);
}

TEST(SignTest, ThePapersPreferenceOnRecordingsIsNotSignificant) {
  // Table 4 of Chen et al. (CVPR 2023): 43 % against 51 % of 200 answers, 24 % against 74 %. The
  // first p is rounded to two digits.
  EXPECT_NEAR(sign_test_p(102, 86), 0.27, 0.005);
  EXPECT_LT(sign_test_p(148, 48), 1e-9);
}

TEST(SignTest, PowerIsTheChanceOfAnUnevenSplit) {
  // Of 10 votes, 9 to 1 has p = 22 / 1024 and 8 to 2 has 112 / 1024.
  const double nine_or_more = 10 * std::pow(0.9, 9) * 0.1 + std::pow(0.9, 10);
  const double one_or_less = 10 * std::pow(0.1, 9) * 0.9 + std::pow(0.1, 10);
  EXPECT_NEAR(sign_test_power(10, 0.9), nine_or_more + one_or_less, kRounding);
  EXPECT_NEAR(sign_test_power(10, 0.5), 22.0 / 1024.0, kRounding);
  EXPECT_DOUBLE_EQ(sign_test_power(5, 1.0), 0.0);
  EXPECT_DOUBLE_EQ(sign_test_power(6, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(sign_test_power(0, 1.0), 0.0);
}

TEST(SignTest, FindsTheSmallestShareOfThatPower) {
  EXPECT_FALSE(detectable_share(5));
  for (const int votes : {6, 20, 200}) {
    const double share = detectable_share(votes).value();
    EXPECT_NEAR(sign_test_power(votes, share), 0.8, 1e-6) << votes;
  }
  EXPECT_LT(*detectable_share(200), *detectable_share(20));
}

}  // namespace
}  // namespace earpoint

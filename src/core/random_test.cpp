#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>

namespace earpoint {
namespace {

TEST(RandomStream, SameSeedAndKeysGiveTheSameNumbers) {
  RandomStream a(7, {1, 2});
  RandomStream b(7, {1, 2});
  RandomStream c(7, {2, 1});
  RandomStream d(8, {1, 2});
  bool all_equal_c = true;
  bool all_equal_d = true;
  for (int i = 0; i < 100; ++i) {
    const auto draw = a.next();
    EXPECT_EQ(draw, b.next());
    all_equal_c = all_equal_c && draw == c.next();
    all_equal_d = all_equal_d && draw == d.next();
  }
  EXPECT_FALSE(all_equal_c);
  EXPECT_FALSE(all_equal_d);
}

TEST(RandomStream, MomentsAreThoseOfTheDistributions) {
  RandomStream random(1);
  constexpr int kDraws = 200000;
  double uniform_sum = 0;
  double normal_sum = 0;
  double normal_squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    uniform_sum += random.uniform();
    const double normal = random.normal();
    normal_sum += normal;
    normal_squares += normal * normal;
  }
  // Five standard errors of each mean.
  EXPECT_NEAR(uniform_sum / kDraws, 0.5, 5 * std::sqrt(1.0 / 12 / kDraws));
  EXPECT_NEAR(normal_sum / kDraws, 0.0, 5 * std::sqrt(1.0 / kDraws));
  EXPECT_NEAR(normal_squares / kDraws, 1.0, 5 * std::sqrt(2.0 / kDraws));
}

TEST(RandomStream, IndexIsUniform) {
  RandomStream random(2);
  std::array<int, 6> counts{};
  constexpr int kDraws = 60000;
  for (int i = 0; i < kDraws; ++i) ++counts[random.index(6)];
  for (const int count : counts) {
    // Five standard deviations of a binomial count.
    EXPECT_NEAR(count, kDraws / 6.0, 5 * std::sqrt(kDraws * (1.0 / 6) * (5.0 / 6)));
  }
}

}  // namespace
}  // namespace earpoint

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/kernels/lattice.h>
#include <earpoint/kernels/stack_plan.h>

namespace earpoint::kernels {
namespace {

PlaneOrder order_of(std::ptrdiff_t samples, std::ptrdiff_t dilation) {
  return plan_layer({3, dilation, true}, samples).order;
}

/// For every sample of the plane, how often a plan computes it.
std::vector<int> visits(const LayerPlan& plan) {
  std::vector<int> count(static_cast<std::size_t>(plan.order.places()));
  for (const Sweep& sweep : plan.used()) {
    const std::ptrdiff_t outputs = shape_of(sweep.scheme).outputs;
    for (std::ptrdiff_t n = 0; n < sweep.columns; ++n) {
      for (std::ptrdiff_t q = 0; q < outputs; ++q) {
        const std::ptrdiff_t place =
            n / sweep.width * outputs * sweep.step + sweep.phase + n % sweep.width + q * sweep.step;
        if (place < plan.order.places()) ++count[place];
      }
    }
  }
  return count;
}

TEST(StackPlan, ComputesEverySampleOnce) {
  for (const std::ptrdiff_t dilation : {1, 3, 9, 27, 81, 243, 729, 2187, 6561, 19683}) {
    for (const std::ptrdiff_t samples : {1, 2, 100, 4001, 16000}) {
      const LayerPlan plan = plan_layer({3, dilation, true}, samples);
      for (const int count : visits(plan)) {
        ASSERT_EQ(count, 1) << "dilation " << dilation << ", " << samples << " samples";
      }
    }
  }
}

TEST(StackPlan, LeavesOutTapsThatSeeOnlyPadding) {
  const LayerPlan plan = plan_layer({3, 19683, true}, 16000);
  ASSERT_EQ(plan.used().size(), 1U);
  EXPECT_EQ(plan.used()[0].scheme, Scheme::taps);
  EXPECT_EQ(plan.used()[0].taps, 1);
  EXPECT_EQ(plan.used()[0].first_tap, 1);

  const LayerPlan causal = plan_layer({4, 100, false}, 250);
  EXPECT_EQ(causal.used()[0].taps, 3);
  EXPECT_EQ(causal.used()[0].first_tap, 1);
}

TEST(StackPlan, UsesTheSchemeThatMultipliesLeast) {
  const auto schemes = [](std::ptrdiff_t samples, std::ptrdiff_t dilation) {
    std::vector<Scheme> found;
    const LayerPlan plan = plan_layer({3, dilation, true}, samples);
    for (const Sweep& sweep : plan.used()) found.push_back(sweep.scheme);
    return found;
  };
  EXPECT_EQ(schemes(16000, 2187), (std::vector<Scheme>{Scheme::four}));
  EXPECT_EQ(schemes(16000, 6561), (std::vector<Scheme>{Scheme::three, Scheme::two}));
  EXPECT_EQ(schemes(10000, 6561), (std::vector<Scheme>{Scheme::two, Scheme::taps}));
  EXPECT_EQ(schemes(300, 100), (std::vector<Scheme>{Scheme::three}));
}

TEST(PlaneOrder, PutsSamplesOfASegmentApart) {
  const PlaneOrder order = order_of(16000, 9);
  EXPECT_EQ(order.segment, 1000);
  EXPECT_EQ(order.place_of(0), 0);
  EXPECT_EQ(order.place_of(1), 16);
  EXPECT_EQ(order.place_of(1000), 1);
  EXPECT_EQ(order.place_of(15999), 15999);
  EXPECT_EQ(order_of(16000, 27).segment, 0);
}

// The factors of F(4,3) are a product of polynomials: at the taps (1, 0, 0), (0, 1, 0), (0, 0, 1)
// they are the powers of each point over its distance from the others.
TEST(Lattice, FactorsArePowersOfThePoints) {
  const std::array<double, 3> first = {1.0, 0.0, 0.0};
  const std::array<double, 3> last = {0.0, 0.0, 1.0};
  const auto at_first = factors_of_taps(Scheme::four, first);
  const auto at_last = factors_of_taps(Scheme::four, last);
  EXPECT_DOUBLE_EQ(at_first[0], 1.0);
  EXPECT_DOUBLE_EQ(at_first[1], -1.0 / 1.5);
  EXPECT_NEAR(at_last[1], at_first[1] * 0.5, 1e-15);
  EXPECT_DOUBLE_EQ(at_first[3], 1.0 / 6.0);
  EXPECT_NEAR(at_last[3], at_first[3] * 2.0, 1e-15);
  EXPECT_DOUBLE_EQ(at_first[5], 0.0);
  EXPECT_DOUBLE_EQ(at_last[5], 1.0);
}

TEST(Lattice, SingleTapsHaveNoTransform) {
  const std::array<double, 3> taps = {1.0, 2.0, 3.0};
  EXPECT_THROW(static_cast<void>(factors_of_taps(Scheme::taps, taps)), std::logic_error);
}

}  // namespace
}  // namespace earpoint::kernels

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gate_test.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "gate-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {

/// gated() of unscaled rows; the sizes are multiples of 16.
void gate_rows(std::span<const float> filter, std::span<const float> gate, std::span<float> out) {
  const hn::ScalableTag<float> d;
  const auto filter_scale = hn::Set(d, static_cast<float>(kFilterScale));
  const auto gate_scale = hn::Set(d, static_cast<float>(kGateScale));
  for (std::size_t i = 0; i < out.size(); i += hn::Lanes(d)) {
    const auto f = hn::Mul(hn::LoadU(d, filter.data() + i), filter_scale);
    const auto g = hn::Mul(hn::LoadU(d, gate.data() + i), gate_scale);
    hn::StoreU(gated(d, f, g), d, out.data() + i);
  }
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <gtest/gtest.h>

#include <earpoint/kernels_testing/every_target.h>

namespace earpoint::kernels {
namespace {

HWY_EXPORT(gate_rows);

double expected_gate(double f, double g) { return std::sin(std::tanh(f) / (1.0 + std::exp(-g))); }

TEST(Gate, AgreesWithTheDefinitionOverTheWholeRange) {
  std::vector<float> filter;
  std::vector<float> gate;
  for (double f = -20.0; f < 20.0; f += 0.0625) {
    for (double g = -20.0; g < 20.0; g += 0.25) {
      filter.push_back(static_cast<float>(f + 0.001 * g));
      gate.push_back(static_cast<float>(g - 0.003 * f));
    }
  }
  for_every_target([&] {
    std::vector<float> out(filter.size());
    HWY_DYNAMIC_DISPATCH(gate_rows)(filter, gate, out);
    double largest = 0.0;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double error = std::abs(out[i] - expected_gate(filter[i], gate[i]));
      if (!(error <= largest)) largest = error;
    }
    // A few units in the last place of 1, which the result does not exceed: the powers of two
    // have a relative error of 2e-7 and what is scaled by log2(e) one of 6e-8.
    EXPECT_LT(largest, 5e-7);
  });
}

TEST(Gate, HoldsAtItsLimits) {
  const float infinity = INFINITY;
  const std::vector<float> filter = {1e4F,  -1e4F, 1e4F, -1e4F,    0.0F,      0.0F, 3e38F, -3e38F,
                                     50.0F, -50.F, 9.0F, infinity, -infinity, 1.0F, 1.0F,  0.0F};
  const std::vector<float> gate = {1e4F, 1e4F,  -1e4F, -1e4F, 1e4F, 0.0F,     3e38F,     3e38F,
                                   0.0F, 50.0F, 50.0F, 1.0F,  1.0F, infinity, -infinity, -1e4F};
  for_every_target([&] {
    std::vector<float> out(filter.size());
    HWY_DYNAMIC_DISPATCH(gate_rows)(filter, gate, out);
    for (std::size_t i = 0; i < out.size(); ++i) {
      // A few units in the last place of 1, as above.
      EXPECT_NEAR(out[i], expected_gate(filter[i], gate[i]), 5e-7) << filter[i] << ' ' << gate[i];
    }
    EXPECT_EQ(out[4], 0.0F);  // padded channels must stay silent
    EXPECT_EQ(out[5], 0.0F);
  });
}

TEST(Gate, NotANumberStaysSo) {
  std::vector<float> filter(16, 0.5F);
  std::vector<float> gate(16, 0.5F);
  filter[3] = NAN;
  gate[6] = NAN;
  for_every_simd_target([&] {
    std::vector<float> out(filter.size());
    HWY_DYNAMIC_DISPATCH(gate_rows)(filter, gate, out);
    for (std::size_t i = 0; i < out.size(); ++i) EXPECT_EQ(std::isnan(out[i]), i == 3 || i == 6);
  });
}

}  // namespace
}  // namespace earpoint::kernels

#endif  // HWY_ONCE

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/envelope.h>

namespace earpoint {
namespace {

constexpr double kTurn = 6.283185307179586476925286766559;

TEST(HilbertEnvelope, OfAModulatedCarrierIsTheModulation) {
  for (const int size : {1000, 1001, 22050}) {
    // All frequencies fit the size, so that the signal is periodic.
    std::vector<float> signal(size);
    std::vector<double> expected(size);
    for (int n = 0; n < size; ++n) {
      const double turn = kTurn * n / size;
      expected[n] = 0.5 + 0.3 * std::cos(3 * turn);
      signal[n] = static_cast<float>(expected[n] * std::cos(100 * turn + 0.4));
    }
    const std::vector<double> found = hilbert_envelope(signal);
    for (int n = 0; n < size; ++n) {
      ASSERT_NEAR(found[n], expected[n], 1e-6) << n;  // the samples are float
    }
  }
}

TEST(HilbertEnvelope, ConstantAndHighestFrequencyAreTheirMagnitudes) {
  for (const double x : hilbert_envelope(std::vector<float>(8, -0.25F)))
    EXPECT_NEAR(x, 0.25, 1e-15);
  const std::vector<float> alternating{0.5F, -0.5F, 0.5F, -0.5F};
  for (const double x : hilbert_envelope(alternating)) EXPECT_NEAR(x, 0.5, 1e-15);
  EXPECT_THROW((void)hilbert_envelope({}), std::logic_error);
}

}  // namespace
}  // namespace earpoint

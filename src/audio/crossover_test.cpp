#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/butterworth.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kRate_hz = 16000.0;
constexpr double kCutoff_hz = 80.0;

/// A filter's steady response to a tone: the transform of its impulse response.
std::complex<double> response(const std::vector<SecondOrderSection>& sections,
                              double frequency_hz) {
  SectionFilter filter(sections);
  std::complex<double> sum;
  for (int i = 0; i < 16000; ++i) {
    const double angle = -2.0 * kPi * frequency_hz * i / kRate_hz;
    sum += filter.process(i == 0 ? 1.0 : 0.0) * std::polar(1.0, angle);
  }
  return sum;
}

double db(std::complex<double> value) { return 20.0 * std::log10(std::abs(value)); }

TEST(LinkwitzRiley, SharesTheSpectrumWithoutGapOrBump) {
  const Crossover crossover = linkwitz_riley(kCutoff_hz, kRate_hz);
  for (const double frequency_hz : {10.0, 40.0, 70.0, 80.0, 95.0, 160.0, 1000.0, 7000.0}) {
    const std::complex<double> low = response(crossover.low, frequency_hz);
    const std::complex<double> high = response(crossover.high, frequency_hz);
    // Rounding of double over a second of response.
    EXPECT_NEAR(db(low + high), 0.0, 1e-6) << frequency_hz;
  }
}

TEST(LinkwitzRiley, FallsByFortyEightDecibelsAnOctave) {
  const Crossover crossover = linkwitz_riley(kCutoff_hz, kRate_hz);
  // Half of the amplitude each is -6.0206 dB.
  EXPECT_NEAR(db(response(crossover.low, kCutoff_hz)), -6.02, 0.01);
  EXPECT_NEAR(db(response(crossover.high, kCutoff_hz)), -6.02, 0.01);
  // 1 / (1 + x^8)^2 of power, x = 2: -48.2 dB. The bilinear transform changes it by 0.02 dB.
  EXPECT_NEAR(db(response(crossover.low, 2 * kCutoff_hz)), -48.2, 0.2);
  EXPECT_NEAR(db(response(crossover.high, kCutoff_hz / 2)), -48.2, 0.2);
}

}  // namespace
}  // namespace earpoint

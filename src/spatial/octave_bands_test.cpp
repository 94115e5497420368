#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint {
namespace {

TEST(OctaveBands, AmplitudesSumToOneEverywhere) {
  for (double frequency_hz = 0.0; frequency_hz < 24000.0; frequency_hz += 3.7) {
    double sum = 0.0;
    for (int band = 0; band < kOctaveBands; ++band) sum += octave_band_weight(band, frequency_hz);
    EXPECT_NEAR(sum, 1.0, 1e-12) << frequency_hz;  // rounding of doubles
  }
}

TEST(OctaveBands, ABandIsAloneAtItsCentre) {
  for (int band = 0; band < kOctaveBands; ++band) {
    for (int other = 0; other < kOctaveBands; ++other) {
      EXPECT_NEAR(octave_band_weight(other, kOctaveBandCentresHz[band]), other == band ? 1.0 : 0.0,
                  1e-12);
    }
  }
  EXPECT_EQ(octave_band_weight(0, 0.0), 1.0);
  EXPECT_EQ(octave_band_weight(7, 24000.0), 1.0);
}

TEST(OctaveBands, NeighboursMeetHalfwayAtTheBandEdge) {
  // The edge of an octave band is sqrt(2) above its centre.
  EXPECT_NEAR(octave_band_weight(4, 1000.0 * std::sqrt(2.0)), 0.5, 1e-12);
  EXPECT_NEAR(octave_band_weight(5, 1000.0 * std::sqrt(2.0)), 0.5, 1e-12);
}

TEST(OctaveBank, GainCurveIsTheWeightedSum) {
  const OctaveBank bank(16000, 512);
  const BandArray gains{0.9F, 0.1F, 0.5F, 0.7F, 0.0F, 1.5F, 0.3F, 0.2F};
  std::vector<float> curve(bank.bins());
  bank.gain_curve(gains, curve);
  for (int bin = 0; bin < bank.bins(); ++bin) {
    double sum = 0.0;
    for (int band = 0; band < kOctaveBands; ++band) {
      sum += gains[band] * octave_band_weight(band, 16000.0 * bin / 512);
    }
    EXPECT_NEAR(curve[bin], sum, 3e-7) << bin;  // float rounding of sums near one
  }
}

TEST(OctaveBank, EqualGainsAreExact) {
  const OctaveBank bank(48000, 4096);
  std::vector<float> curve(bank.bins());
  bank.gain_curve(all_bands(0.3F), curve);
  for (const float gain : curve) EXPECT_EQ(gain, 0.3F);
}

TEST(OctaveBank, RefusesWhatIsNotABank) {
  EXPECT_THROW(OctaveBank(0, 512), std::logic_error);
  EXPECT_THROW(OctaveBank(16000, 511), std::logic_error);
  const OctaveBank bank(16000, 512);
  std::vector<float> curve(7);
  EXPECT_THROW(bank.gain_curve(all_bands(1.0F), curve), std::logic_error);
  EXPECT_THROW(static_cast<void>(octave_band_weight(8, 100.0)), std::logic_error);
}

}  // namespace
}  // namespace earpoint

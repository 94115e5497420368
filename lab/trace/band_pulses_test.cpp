#include "band_pulses.h"

#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

std::complex<double> sum_at(const std::vector<BandPulse>& pulses, int band, double frequency_hz) {
  std::complex<double> sum = 0.0;
  for (const BandPulse& pulse : pulses) {
    sum += static_cast<double>(pulse.gain[band]) *
           std::polar(1.0, -2.0 * kPi * frequency_hz * pulse.later_s);
  }
  return sum;
}

DiffractionSpectrum constant(std::complex<double> pressure) {
  DiffractionSpectrum spectrum;
  spectrum.fill(pressure);
  return spectrum;
}

TEST(BandPulses, HaveAnyPhaseAtTheBandsCentre) {
  for (double phase = -3.0; phase <= 3.0; phase += 0.25) {
    const auto pulses = band_pulses(constant(std::polar(0.3, phase)));
    for (int band = 0; band < kOctaveBands; ++band) {
      const std::complex<double> found = sum_at(pulses, band, kOctaveBandCentresHz[band]);
      // Gains are floats.
      EXPECT_NEAR(std::arg(found * std::polar(1.0, -phase)), 0.0, 1e-5) << phase << " " << band;
    }
  }
}

TEST(BandPulses, KeepTheEnergyOfTheOctave) {
  for (double phase = -3.0; phase <= 3.0; phase += 0.25) {
    const auto pulses = band_pulses(constant(std::polar(0.3, phase)));
    for (int band = 0; band < kOctaveBands; ++band) {
      constexpr int kSteps = 200;
      const double low_hz = kOctaveBandCentresHz[band] * std::sqrt(0.5);
      const double width_hz = kOctaveBandCentresHz[band] * (std::sqrt(2.0) - std::sqrt(0.5));
      double energy = 0.0;
      for (int i = 0; i < kSteps; ++i) {
        energy += std::norm(sum_at(pulses, band, low_hz + width_hz * (i + 0.5) / kSteps)) / kSteps;
      }
      // The midpoint rule of 200 steps.
      EXPECT_NEAR(std::sqrt(energy), 0.3, 1e-4) << phase << " " << band;
    }
  }
}

TEST(BandPulses, SoundInPhaseIsOnePulse) {
  const auto pulses = band_pulses(constant(-0.5));
  for (int band = 0; band < kOctaveBands; ++band) {
    EXPECT_FLOAT_EQ(pulses[0].gain[band], -0.5F);
    for (std::size_t i = 1; i < pulses.size(); ++i) EXPECT_NEAR(pulses[i].gain[band], 0.0F, 1e-7F);
  }
}

TEST(BandPulses, SilenceStaysSilent) {
  const std::vector<BandPulse> pulses = band_pulses({});
  ASSERT_FALSE(pulses.empty());
  for (const BandPulse& pulse : pulses) {
    for (const float gain : pulse.gain) EXPECT_EQ(gain, 0.0F);
  }
}

}  // namespace
}  // namespace earpoint

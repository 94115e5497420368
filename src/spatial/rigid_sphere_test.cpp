#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/fft.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/dsp_renderer.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/spatial/rigid_sphere.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;

const HrtfSet& kemar() {
  static const HrtfSet set = HrtfSet::load(kRate_hz);
  return set;
}

double db(double ratio) { return 20.0 * std::log10(ratio); }

// Left over right, as a level.
double sphere_ild_db(double frequency_hz, double distance_m, double towards_left) {
  const auto ears = rigid_sphere_ears(frequency_hz, distance_m, towards_left);
  return db(std::abs(ears[0]) / std::abs(ears[1]));
}

double magnitude(const std::vector<float>& taps, double frequency_hz) {
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < taps.size(); ++i) {
    sum += static_cast<double>(taps[i]) *
           std::polar(1.0, -2.0 * kPi * frequency_hz / kRate_hz * static_cast<double>(i));
  }
  return std::abs(sum);
}

double ild_db(const Hrir& hrir, double frequency_hz) {
  return db(magnitude(hrir.taps[0], frequency_hz) / magnitude(hrir.taps[1], frequency_hz));
}

TEST(RigidSphere, FarSourceOfLowFrequencyPassesAsIfItWereNotThere) {
  const auto ears = rigid_sphere_ears(5.0, 1000.0, 0.3);
  // First order in the wave number: 3/2 ka cos is 4e-3 in phase, nothing in level. Second order and
  // nearness, a / r, are below 1e-4 each.
  EXPECT_NEAR(std::abs(ears[0]), 1.0, 1e-3);
  EXPECT_NEAR(std::abs(ears[1]), 1.0, 1e-3);
}

TEST(RigidSphere, FacingEndDoublesThePressureOfShortWaves) {
  // ka = 35: the surface is nearly flat. The series is exact to 1e-7, the limit to 1/ka.
  EXPECT_NEAR(std::abs(rigid_sphere_ears(22000.0, 1000.0, 1.0)[0]), 2.0, 0.06);
}

TEST(RigidSphere, AtRestTheSeriesIsTheStaticOne) {
  // Laplace's equation: rho sum (2m+1)/(m+1) rho^-(m+1) P_m, for cos = 1 with P_m = 1. In place of
  // 0 Hz the series is summed at 1 Hz, (kr)^2 = 3e-5.
  const double rho = 0.3 / kHeadRadius_m;
  double expected = 0.0;
  for (int m = 0; m < 60; ++m) expected += (2.0 * m + 1.0) / (m + 1.0) * std::pow(rho, -m);
  EXPECT_NEAR(std::abs(rigid_sphere_ears(0.0, 0.3, 1.0)[0]), expected, 1e-4);
}

TEST(RigidSphere, LevelBetweenTheEarsGrowsWithNearness) {
  // Duda and Martens' series with ears at +-90 degrees, computed independently of this code, to two
  // decimals.
  const double frequencies_hz[] = {250.0, 500.0, 1000.0};
  const double growth_db[] = {6.04, 5.48, 5.27};
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(
        sphere_ild_db(frequencies_hz[i], 0.3, 1.0) - sphere_ild_db(frequencies_hz[i], 1.4, 1.0),
        growth_db[i], 0.01);
  }
}

TEST(RigidSphere, WayRoundTheHeadIsLongerFromNearby) {
  const auto far = rigid_sphere_delays_s(100.0, 1.0);
  const auto near = rigid_sphere_delays_s(0.2, 1.0);
  EXPECT_NEAR(far[0], -kHeadRadius_m / 343.2, 1e-6);
  EXPECT_NEAR(far[1], kPi / 2.0 * kHeadRadius_m / 343.2, 1e-6);
  EXPECT_NEAR(near[0], far[0], 1e-9);
  EXPECT_GT(near[1], far[1] + 1e-5);
}

TEST(NearField, HrtfFollowsTheSphereWithinADecibel) {
  for (const double azimuth_rad : {kPi / 2.0, kPi / 4.0, -2.0}) {
    const Vector3 direction{std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0};
    const Hrir measured = kemar().interpolated(direction);
    for (const double distance_m : {0.15, 0.3, 0.6, 1.0}) {
      const Hrir near = kemar().interpolated(direction, distance_m);
      for (const double frequency_hz : {250.0, 500.0, 1000.0, 2000.0, 4000.0}) {
        const double growth_db = ild_db(near, frequency_hz) - ild_db(measured, frequency_hz);
        const double expected_db = sphere_ild_db(frequency_hz, distance_m, direction.y) -
                                   sphere_ild_db(frequency_hz, 1.4, direction.y);
        // The truncation of the response changes the level by less than this.
        EXPECT_NEAR(growth_db, expected_db, 0.3) << distance_m << " m " << frequency_hz << " Hz";
      }
    }
  }
}

TEST(NearField, StartsWithoutAStepWhereTheSetWasMeasured) {
  EXPECT_NEAR(kemar().distance_m(), 1.4, 1e-6);
  const Vector3 left{0.0, 1.0, 0.0};
  const Hrir at = kemar().interpolated(left);
  const Hrir within = kemar().interpolated(left, 1.4 - 1e-4);
  const Hrir beyond = kemar().interpolated(left, 5.0);
  for (int ear = 0; ear < 2; ++ear) {
    EXPECT_EQ(at.taps[ear], beyond.taps[ear]);
    float peak = 0.0F;
    for (const float tap : at.taps[ear]) peak = std::max(peak, std::abs(tap));
    for (std::size_t i = 0; i < at.taps[ear].size(); ++i) {
      // 0.1 mm of 1.4 m: 1e-4 in level.
      EXPECT_NEAR(at.taps[ear][i], within.taps[ear][i], 3e-4 * peak);
    }
  }
}

TEST(NearField, OnsetMovesAsTheSoundDoes) {
  const Vector3 left{0.0, 1.0, 0.0};
  const Hrir far = kemar().interpolated(left);
  const Hrir near = kemar().interpolated(left, 0.2);
  const auto here = rigid_sphere_delays_s(0.2, 1.0);
  const auto there = rigid_sphere_delays_s(1.4, 1.0);
  EXPECT_NEAR(near.onset_samples[1] - far.onset_samples[1], (here[1] - there[1]) * kRate_hz, 1e-6);
  // The actual time of the far ear's response, by its centre of energy, agrees to half a sample.
  const auto centre = [](const std::vector<float>& taps) {
    double sum = 0.0;
    double moment = 0.0;
    for (std::size_t i = 0; i < taps.size(); ++i) {
      const double energy = static_cast<double>(taps[i]) * static_cast<double>(taps[i]);
      sum += energy;
      moment += energy * static_cast<double>(i);
    }
    return moment / sum;
  };
  EXPECT_NEAR(centre(near.taps[1]) - centre(far.taps[1]),
              near.onset_samples[1] - far.onset_samples[1], 0.5);
}

TEST(NearField, DspRendersIt) {
  // The filters from a speaker in front, 2 m away, to one at the left ear.
  const EarFilterMatrix filters =
      dsp_filters(kemar(), Spherical{0.0, 0.0, 2.0}, Spherical{kPi / 2.0, 0.0, 0.3});
  const EarFilterMatrix far =
      dsp_filters(kemar(), Spherical{0.0, 0.0, 2.0}, Spherical{kPi / 2.0, 0.0, 1.4});
  const auto level_db = [](const EarFilterMatrix& matrix, double frequency_hz) {
    return db(magnitude(matrix.taps[0][0], frequency_hz) /
              magnitude(matrix.taps[1][0], frequency_hz));
  };
  for (const double frequency_hz : {250.0, 500.0, 1000.0}) {
    const double expected_db =
        sphere_ild_db(frequency_hz, 0.3, 1.0) - sphere_ild_db(frequency_hz, 1.4, 1.0);
    // The fades of the filters smooth the spectrum a little.
    EXPECT_NEAR(level_db(filters, frequency_hz) - level_db(far, frequency_hz), expected_db, 0.5);
  }
}

}  // namespace
}  // namespace earpoint

#include "wedge_diffraction.h"

#include "gates/references.h"

#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kSpeed = 343.2;
const EdgeInterval kLong[] = {{-60.0, 60.0}};

// The mean over the octave, as the tracer computes it.
double utd_level_db(double open_angle, double source_angle, double source_m, double receiver_angle,
                    double receiver_m, int band) {
  double energy = 0.0;
  for (const double octaves : {-1.0 / 3.0, 0.0, 1.0 / 3.0}) {
    const double wave_number = 2.0 * kPi * kOctaveBandCentresHz[band] * std::exp2(octaves) / kSpeed;
    energy += std::norm(gates::wedge_pressure(open_angle, source_angle, source_m, receiver_angle,
                                              receiver_m, wave_number)) /
              3.0;
  }
  return 10.0 * std::log10(energy);
}

// Per band the root of the mean energy, with the sign of the real part.
BandArray gains(const Wedge& wedge, const EdgePoint& source, const EdgePoint& receiver,
                std::span<const EdgeInterval> intervals, const UnbentSound& unbent = {}) {
  const DiffractionSpectrum spectrum = diffract(wedge, source, receiver, intervals, unbent, kSpeed);
  BandArray gains;
  for (int band = 0; band < kOctaveBands; ++band) {
    double energy = 0.0;
    double real = 0.0;
    for (int i = 0; i < kFrequenciesPerBand; ++i) {
      const std::complex<double>& part = spectrum[band * kFrequenciesPerBand + i];
      energy += std::norm(part) / kFrequenciesPerBand;
      real += part.real();
    }
    gains[band] = static_cast<float>(std::copysign(std::sqrt(energy), real));
  }
  return gains;
}

TEST(WedgeDiffraction, IsHalfTheDirectSoundOnTheShadowBoundary) {
  // A half-plane: source at 60 degrees, receiver just behind 60 + 180.
  const Wedge wedge{.open_angle_rad = 2.0 * kPi};
  const EdgePoint source{2.0, kPi / 3.0, 0.0};
  const EdgePoint receiver{3.0, kPi / 3.0 + kPi + 1e-3, 0.0};
  const BandArray sound = gains(wedge, source, receiver, kLong);
  EXPECT_NEAR(find_apex(source, receiver, kLong).distance_m, 5.0, 1e-9);
  for (int band = 2; band < kOctaveBands; ++band) {
    // The reflection's term adds 8 % at 250 Hz and falls with the root of the frequency; the step
    // off the boundary takes 4 % at 8 kHz.
    EXPECT_NEAR(sound[band] * 5.0F, 0.5F, band < 4 ? 0.09F : 0.05F) << band;
  }
  // In front of the boundary it removes half.
  const EdgePoint lit{3.0, kPi / 3.0 + kPi - 1e-3, 0.0};
  EXPECT_NEAR(gains(wedge, source, lit, kLong)[5] * 5.0F, -0.5F, 0.05F);
}

TEST(WedgeDiffraction, FollowsTheUniformTheoryBehindWedges) {
  for (const double open_angle : {1.5 * kPi, 1.75 * kPi, 2.0 * kPi}) {
    for (const double source_angle : {0.3, 1.0}) {
      for (const double behind : {0.15, 0.5, 1.0}) {
        const double receiver_angle = source_angle + kPi + behind;
        if (receiver_angle >= open_angle) continue;
        const BandArray sound = gains({.open_angle_rad = open_angle}, {2.5, source_angle, 0.0},
                                      {1.8, receiver_angle, 0.0}, kLong);
        for (int band = 3; band < kOctaveBands; ++band) {
          const double level_db = 20.0 * std::log10(static_cast<double>(sound[band]));
          // The uniform theory is asymptotic: at 500 Hz the wave is 0.7 m, on paths of 2 m.
          EXPECT_NEAR(level_db,
                      utd_level_db(open_angle, source_angle, 2.5, receiver_angle, 1.8, band), 0.3)
              << open_angle << " " << source_angle << " " << behind << " band " << band;
        }
      }
    }
  }
}

TEST(WedgeDiffraction, OnTheShadowBoundaryItTakesTheSideOfTheStraightSound) {
  const Wedge wedge{.open_angle_rad = 1.5 * kPi};
  const EdgePoint source{2.0, kPi / 3.0, 0.0};
  for (const double off_rad : {0.0, 1e-9, -1e-9, 1e-5, -1e-5}) {
    const EdgePoint receiver{3.0, kPi / 3.0 + kPi + off_rad, 0.0};
    const bool touches = std::abs(off_rad) < kOnBoundary_rad;
    const float free = gains(wedge, source, receiver, kLong, {.straight = true})[5];
    const float blocked = gains(wedge, source, receiver, kLong, {.straight = false})[5];
    // Half of 1/5, however close the boundary is; the reflection adds 0.013 on either side.
    EXPECT_NEAR(free, touches || off_rad < 0.0 ? -0.1F : 0.1F, 0.016F) << off_rad;
    EXPECT_NEAR(blocked, touches || off_rad > 0.0 ? 0.1F : -0.1F, 0.016F) << off_rad;
  }
}

TEST(WedgeDiffraction, FlatWallDoesNotDiffract) {
  const BandArray sound = gains({.open_angle_rad = kPi}, {1.0, 0.6, 0.0}, {2.0, 2.0, 0.5}, kLong);
  for (const float gain : sound) EXPECT_NEAR(gain, 0.0F, 1e-9F);
}

TEST(WedgeDiffraction, IsReciprocal) {
  const Wedge wedge{.open_angle_rad = 1.5 * kPi};
  const EdgePoint here{2.0, 0.4, 0.3};
  const EdgePoint there{1.2, 4.4, -0.5};
  const EdgeInterval door[] = {{-1.0, 1.0}};
  const BandArray a = gains(wedge, here, there, door);
  const BandArray b = gains(wedge, there, here, door);
  for (int band = 0; band < kOctaveBands; ++band) {
    // Floats of up to 0.1, with a last bit of 7e-9, summed over a few hundred steps in opposite
    // order.
    EXPECT_NEAR(a[band], b[band], 1e-7F);
    EXPECT_GT(std::abs(a[band]), 1e-3F) << "there is a sound";
  }
}

TEST(WedgeDiffraction, IntervalsThatTouchAreOneEdge) {
  const Wedge wedge{.open_angle_rad = 1.5 * kPi};
  const EdgePoint here{2.0, 0.4, 0.3};
  const EdgePoint there{1.2, 4.4, -0.5};
  const EdgeInterval whole[] = {{-1.0, 1.0}};
  const EdgeInterval parts[] = {{-1.0, 0.1}, {0.1, 1.0}};
  const BandArray a = gains(wedge, here, there, whole);
  const BandArray b = gains(wedge, here, there, parts);
  // The steps of the integration differ.
  for (int band = 0; band < kOctaveBands; ++band) {
    EXPECT_NEAR(a[band] / b[band], 1.0F, 0.02F) << band;
  }
}

TEST(WedgeDiffraction, DeeperShadowAndHigherSoundAreQuieter) {
  const Wedge wedge{.open_angle_rad = 2.0 * kPi};
  double last = 1.0;
  for (const double behind : {0.1, 0.3, 0.6, 1.0, 1.5}) {
    const BandArray sound = gains(wedge, {2.0, 1.0, 0.0}, {2.0, 1.0 + kPi + behind, 0.0}, kLong);
    EXPECT_LT(sound[4], last);
    for (int band = 1; band < kOctaveBands; ++band) {
      EXPECT_LT(sound[band], sound[band - 1]);
    }
    last = static_cast<double>(sound[4]);
  }
}

}  // namespace
}  // namespace earpoint

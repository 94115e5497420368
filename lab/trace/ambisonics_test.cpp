#include "ambisonics.h"

#include "sphere_points.h"

#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>
#include <earpoint/trace/response_synthesizer.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;

TEST(Ambisonics, FirstOrderIsTheDirection) {
  const Vector3 direction{0.48, -0.6, 0.64};
  std::vector<float> gains(4);
  encode_ambisonics(direction, 1, gains);
  const double root = std::sqrt(3.0);
  EXPECT_NEAR(gains[0], 1.0, 1e-6);
  EXPECT_NEAR(gains[1], root * direction.y, 1e-6);
  EXPECT_NEAR(gains[2], root * direction.z, 1e-6);
  EXPECT_NEAR(gains[3], root * direction.x, 1e-6);
}

TEST(Ambisonics, SecondOrderHasItsClosedForm) {
  const Vector3 d{0.48, -0.6, 0.64};
  std::vector<float> gains(9);
  encode_ambisonics(d, 2, gains);
  EXPECT_NEAR(gains[4], std::sqrt(15.0) * d.x * d.y, 1e-6);
  EXPECT_NEAR(gains[5], std::sqrt(15.0) * d.y * d.z, 1e-6);
  EXPECT_NEAR(gains[6], std::sqrt(5.0) / 2.0 * (3.0 * d.z * d.z - 1.0), 1e-6);
  EXPECT_NEAR(gains[7], std::sqrt(15.0) * d.x * d.z, 1e-6);
  EXPECT_NEAR(gains[8], std::sqrt(15.0) / 2.0 * (d.x * d.x - d.y * d.y), 1e-6);
}

TEST(Ambisonics, HarmonicsAreOrthonormalOverTheSphere) {
  constexpr int kOrder = 5;
  constexpr int kPoints = 4000;
  const int channels = ambisonic_channels(kOrder);
  std::vector<double> products(static_cast<std::size_t>(channels) * channels);
  std::vector<float> gains(channels);
  for (int i = 0; i < kPoints; ++i) {
    encode_ambisonics(spiral_direction(i, 0.5, kPoints, 0.0), kOrder, gains);
    // The sum of the squares is the same in all directions: (order + 1)^2.
    EXPECT_NEAR(energy(gains), channels, 1e-4);
    for (int a = 0; a < channels; ++a) {
      for (int b = 0; b < channels; ++b) {
        products[a * channels + b] += static_cast<double>(gains[a] * gains[b]) / kPoints;
      }
    }
  }
  for (int a = 0; a < channels; ++a) {
    for (int b = 0; b < channels; ++b) {
      // A sum over 4000 evenly spread points has an error of about 1e-3.
      EXPECT_NEAR(products[a * channels + b], a == b ? 1.0 : 0.0, 5e-3) << a << " " << b;
    }
  }
}

TEST(AmbisonicResponse, ArrivalIsEncodedInTheHeadsFrame) {
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz, .duration_s = 0.1});
  PointResponse response;
  response.arrivals = {{.delay_s = 0.03125,  // 500 samples
                        .direction = {1, 0, 0},
                        .departure = {},
                        .gain = all_bands(0.5F)}};
  response.late = EnergyHistogram(50, 0.002);
  // Looking along y, the world's x is on the right.
  const Waveform sound =
      synthesizer.ambisonic(response, quaternion_from_euler({.yaw_rad = kPi / 2}), 1, 0);
  ASSERT_EQ(sound.channels(), 4);
  // The pulse's peak is the mean of its spectrum, which rolls off over the top 8 %: 0.96. The pulse
  // train's error is 1e-6.
  constexpr double kPeak = 0.96;
  EXPECT_NEAR(sound.channel(0)[500], kPeak * 0.5, 1e-4);
  EXPECT_NEAR(sound.channel(1)[500], -kPeak * 0.5 * std::sqrt(3.0), 1e-4);
  EXPECT_NEAR(sound.channel(2)[500], 0.0F, 1e-4F);
  EXPECT_NEAR(sound.channel(3)[500], 0.0F, 1e-4F);
}

TEST(AmbisonicResponse, DiffuseFieldIsAsLoudInEveryChannel) {
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz, .duration_s = 1.0});
  PointResponse response;
  response.late = EnergyHistogram(500, 0.002);
  for (int bin = 0; bin < 500; ++bin) {
    for (int sector = 0; sector < kSectors; ++sector) {
      response.late.at(bin, sector) = all_bands(1e-4F);
    }
  }
  const Waveform sound = synthesizer.ambisonic(response, {}, 2, 0);
  const double mono = energy(synthesizer.mono(response, 0).channel(0));
  for (int channel = 0; channel < 9; ++channel) {
    // One draw of noise: the mean over 32 sectors of 16000 samples each.
    EXPECT_NEAR(energy(sound.channel(channel)) / mono, 1.0, 0.1) << channel;
  }
  // Sound from one side only has that direction's gains in the channels.
  const int left = sector_of(0.0F, 1.0F, 0.0F);
  for (int bin = 0; bin < 500; ++bin) {
    for (int sector = 0; sector < kSectors; ++sector) {
      if (sector != left) response.late.at(bin, sector) = {};
    }
  }
  const Waveform side = synthesizer.ambisonic(response, {}, 1, 0);
  std::vector<float> gains(4);
  encode_ambisonics(sector_direction(left), 1, gains);
  const double cross = std::inner_product(side.channel(0).begin(), side.channel(0).end(),
                                          side.channel(1).begin(), 0.0);
  // Both channels carry the same noise: exact except for float rounding and the fade between bins.
  EXPECT_NEAR(cross / energy(side.channel(0)), gains[1], 1e-3);
}

}  // namespace
}  // namespace earpoint

#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/trace/source.h>

namespace earpoint {
namespace {

TEST(Directivity, DefaultIsTheSameInAllDirections) {
  EXPECT_EQ(Directivity().energy({0, 0, 1}), all_bands(1.0F));
}

TEST(Directivity, InterpolatesBetweenTheTablesDirections) {
  // Columns at -180, -90, 0, 90 degrees; rows straight down, level, straight up.
  std::vector<BandArray> table(12, all_bands(0.0F));
  table[4 + 2] = all_bands(1.0F);
  table[4 + 3] = all_bands(0.5F);
  const Directivity directivity(4, 3, table);
  const auto at = [&](double azimuth_deg, double elevation_deg) {
    return directivity.energy(
        cartesian_from_spherical({.azimuth_rad = radians_from_degrees(azimuth_deg),
                                  .elevation_rad = radians_from_degrees(elevation_deg),
                                  .distance_m = 1.0}))[0];
  };
  EXPECT_NEAR(at(0, 0), 1.0F, 1e-6F);
  EXPECT_NEAR(at(45, 0), 0.75F, 1e-6F);
  EXPECT_NEAR(at(90, 0), 0.5F, 1e-6F);
  EXPECT_NEAR(at(-45, 0), 0.5F, 1e-6F);
  EXPECT_NEAR(at(135, 0), 0.25F, 1e-6F);  // towards the column at 180 = -180
  EXPECT_NEAR(at(180, 0), 0.0F, 1e-6F);
  EXPECT_NEAR(at(0, 45), 0.5F, 1e-6F);
  EXPECT_NEAR(at(0, 90), 0.0F, 1e-6F);
}

TEST(Directivity, IsTheSameAroundTheFront) {
  // 0, 90 and 180 degrees from the front.
  const Directivity directivity =
      Directivity::about_front({all_bands(1.0F), all_bands(0.5F), all_bands(0.0F)});
  EXPECT_NEAR(directivity.energy({1, 0, 0})[3], 1.0F, 1e-6F);
  EXPECT_NEAR(directivity.energy({0, 1, 0})[3], 0.5F, 1e-6F);
  EXPECT_NEAR(directivity.energy({0, 0, -1})[3], 0.5F, 1e-6F);
  EXPECT_NEAR(directivity.energy({-1, 0, 0})[3], 0.0F, 1e-6F);
  const double half = std::sqrt(0.5);
  EXPECT_NEAR(directivity.energy({half, 0, half})[3], 0.75F, 1e-6F);
}

TEST(Directivity, MeanEnergyIsTheIntegralOverTheSphere) {
  EXPECT_EQ(Directivity().mean_energy(), all_bands(1.0F));
  // A cardioid: energy ((1 + cos) / 2)^2, whose mean is 1/3. A table every 2 degrees.
  std::vector<BandArray> cardioid;
  for (int i = 0; i <= 90; ++i) {
    const double pressure = (1.0 + std::cos(kPi * i / 90.0)) / 2.0;
    cardioid.push_back(all_bands(static_cast<float>(pressure * pressure)));
  }
  // The table's straight lines lie above the curve by up to 2e-4 of it.
  EXPECT_NEAR(Directivity::about_front(cardioid).mean_energy()[0], 1.0F / 3.0F, 3e-4F);
  // The half-sphere above the horizon as a table over azimuth and elevation: the row of the horizon
  // has 1/2, and interpolation to it does not change the mean.
  const Directivity above(1, 3, {all_bands(0.0F), all_bands(0.5F), all_bands(1.0F)});
  EXPECT_NEAR(above.mean_energy()[0], 0.5F, 1e-4F);
}

TEST(SpeechDirectivity, IsQuieterBehindAsPublished) {
  const Directivity speech = speech_directivity();
  const BandArray front = speech.energy({1, 0, 0});
  const BandArray behind = speech.energy({-1, 0, 0});
  const BandArray side = speech.energy({0, 1, 0});
  const std::array<double, kOctaveBands> behind_db = {-3.6, -3.6,  -5.1,  -5.9,
                                                      -6.3, -13.1, -18.9, -26.3};
  const std::array<double, kOctaveBands> side_db = {-1.6, -1.6, -2.3, -1.6, -1.6, -7.0, -6.3, -8.7};
  for (int band = 0; band < kOctaveBands; ++band) {
    EXPECT_FLOAT_EQ(front[band], 1.0F);
    // The table has a tenth of a dB.
    EXPECT_NEAR(10.0 * std::log10(static_cast<double>(behind[band])), behind_db[band], 1e-3);
    EXPECT_NEAR(10.0 * std::log10(static_cast<double>(side[band])), side_db[band], 1e-3);
  }
}

TEST(SpeechDirectivity, SendsLessInAllThanASourceThatIsAsLoudAllRound) {
  const BandArray mean = speech_directivity().mean_energy();
  for (int band = 0; band < kOctaveBands; ++band) {
    // Directivity indices of talkers lie between 1 and 9 dB.
    const double index_db = -10.0 * std::log10(static_cast<double>(mean[band]));
    EXPECT_GT(index_db, 1.0) << band;
    EXPECT_LT(index_db, 9.0) << band;
  }
  EXPECT_LT(mean[7], mean[1]);
}

TEST(Directivity, RefusesTablesThatDoNotFit) {
  EXPECT_THROW(Directivity::about_front({all_bands(1.0F)}), std::logic_error);
  EXPECT_THROW(Directivity(4, 3, std::vector<BandArray>(11)), std::logic_error);
  EXPECT_THROW(Directivity(4, 3, std::vector<BandArray>(12, all_bands(-1.0F))), std::logic_error);
}

}  // namespace
}  // namespace earpoint

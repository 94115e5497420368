#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/spatial/air_absorption.h>

namespace earpoint {
namespace {

struct Row {
  double temperature_celsius;
  double humidity_percent;
  BandArray db_per_km;
};

// The attenuation coefficients that ISO 9613-2:1996 tabulates from ISO 9613-1 (its table 2).
const std::vector<Row> kTable = {
    {10, 70, {0.1F, 0.4F, 1.0F, 1.9F, 3.7F, 9.7F, 32.8F, 117.0F}},
    {20, 70, {0.1F, 0.3F, 1.1F, 2.8F, 5.0F, 9.0F, 22.9F, 76.6F}},
    {30, 70, {0.1F, 0.3F, 1.0F, 3.1F, 7.4F, 12.7F, 23.1F, 59.3F}},
    {15, 20, {0.3F, 0.6F, 1.2F, 2.7F, 8.2F, 28.2F, 88.8F, 202.0F}},
    {15, 50, {0.1F, 0.5F, 1.2F, 2.2F, 4.2F, 10.8F, 36.2F, 129.0F}},
    {15, 80, {0.1F, 0.3F, 1.1F, 2.4F, 4.1F, 8.3F, 23.7F, 82.8F}},
};

TEST(AirAbsorption, MatchesTheTableOfTheStandard) {
  for (const Row& row : kTable) {
    const Air air{row.temperature_celsius, row.humidity_percent};
    for (int band = 0; band < kOctaveBands; ++band) {
      // The table is for the exact midbands 1000 * 10^(0.3 k) Hz, 63.1 Hz to 7943 Hz.
      const double midband_hz = 1000.0 * std::pow(10.0, 0.3 * (band - 4));
      const double found = 1000.0 * air_absorption_db_per_m(midband_hz, air);
      // Half a unit in the last printed digit (0.1 up to 100, then 1), and 3 % of that: the table
      // was rounded from three digits.
      const double half_unit = row.db_per_km[band] >= 100.0F ? 0.5 : 0.05;
      EXPECT_NEAR(found, row.db_per_km[band], half_unit * 1.03)
          << row.temperature_celsius << " C " << row.humidity_percent << " % " << midband_hz;
    }
  }
}

TEST(AirAbsorption, DryAirIsLeftWithClassicalLossAtHighFrequency) {
  // Far above both relaxations the loss per square of the frequency tends to the classical term
  // (8.686 * 1.84e-11) plus constants of relaxation: it must grow as the square.
  const Air air{20.0, 10.0};
  const double ratio = air_absorption_db_per_m(8e6, air) / air_absorption_db_per_m(4e6, air);
  // The relaxations add a constant that is 0.01 % of the classical loss here.
  EXPECT_NEAR(ratio, 4.0, 1e-3);
}

TEST(AirAbsorption, NoSoundNoLoss) { EXPECT_EQ(air_absorption_db_per_m(0.0, Air{}), 0.0); }

TEST(AirAbsorption, GainIsTheAttenuationInPressure) {
  BandArray db_per_m = all_bands(0.2F);
  // 0.2 dB/m over 100 m is 20 dB: a tenth. The tolerance is float rounding.
  EXPECT_NEAR(air_gain(db_per_m, 100.0)[3], 0.1F, 1e-7F);
  EXPECT_EQ(air_gain(db_per_m, 0.0)[3], 1.0F);
}

TEST(AirAbsorption, RefusesAirThatIsNot) {
  EXPECT_THROW(check_air({.temperature_celsius = 200.0}), InputError);
  EXPECT_THROW(check_air({.relative_humidity_percent = -1.0}), InputError);
  EXPECT_THROW(check_air({.pressure_kpa = 0.0}), InputError);
  EXPECT_THROW(check_air({.pressure_kpa = std::nan("")}), InputError);
}

TEST(SpeedOfSound, FollowsTheTemperature) {
  EXPECT_NEAR(speed_of_sound_m_per_s({.temperature_celsius = 20.0}), 343.2, 1e-9);
  // 331.3 m/s at 0 degrees, as tabulated to one decimal.
  EXPECT_NEAR(speed_of_sound_m_per_s({.temperature_celsius = 0.0}), 331.3, 0.05);
}

}  // namespace
}  // namespace earpoint

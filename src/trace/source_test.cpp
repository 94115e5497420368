#include <gtest/gtest.h>

#include <earpoint/trace/source.h>

namespace earpoint {
namespace {

TEST(Directivity, DefaultIsTheSameInAllDirections) {
  EXPECT_EQ(Directivity().energy({0, 0, 1}), all_bands(1.0F));
}

TEST(Directivity, InterpolatesBetweenTheTablesDirections) {
  // Columns at -180, -90, 0, 90 degrees; rows straight down, level, straight up.
  std::vector<BandArray> table(3 * 4, all_bands(0.0F));
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

TEST(Directivity, RefusesTablesThatDoNotFit) {
  EXPECT_THROW(Directivity(4, 3, std::vector<BandArray>(11)), std::logic_error);
  EXPECT_THROW(Directivity(4, 3, std::vector<BandArray>(12, all_bands(-1.0F))), std::logic_error);
}

}  // namespace
}  // namespace earpoint

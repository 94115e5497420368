#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/trace/response_end.h>

namespace earpoint {
namespace {

constexpr double kBin_s = 0.002;

// Falls by 60 dB in the given time, in all bands but those that are named as silent.
PointResponse decay(double time_s, double duration_s) {
  PointResponse response;
  response.late = EnergyHistogram(static_cast<int>(duration_s / kBin_s), kBin_s);
  for (int bin = 0; bin < response.late.bins(); ++bin) {
    response.late.at(bin, 0) =
        all_bands(static_cast<float>(std::pow(10.0, -6.0 * bin * kBin_s / time_s)));
  }
  return response;
}

TEST(ResponseEnd, SaysTheLevelAndTheLengthThatIsNeeded) {
  const ResponseEnd end = response_end(decay(3.0, 1.0), 1.0);
  // 20 dB a second over the 0.95 s between the windows.
  EXPECT_NEAR(end.level_db, -19.0, 0.3);
  EXPECT_NEAR(end.needed_s, 3.05, 0.03);
}

TEST(ResponseEnd, NeedsNoMoreWhereAllHasDecayed) {
  const ResponseEnd end = response_end(decay(0.5, 1.0), 1.0);
  EXPECT_LT(end.level_db, -60.0);
  EXPECT_EQ(end.needed_s, 1.0);
}

TEST(ResponseEnd, TheSlowestBandDecides) {
  PointResponse response = decay(0.3, 1.0);
  for (int bin = 0; bin < response.late.bins(); ++bin) {
    response.late.at(bin, 0)[1] = static_cast<float>(std::pow(10.0, -3.0 * bin * kBin_s));
  }
  const ResponseEnd end = response_end(response, 1.0);
  // 30 dB a second over the 0.95 s between the windows; 60 dB take two seconds.
  EXPECT_NEAR(end.level_db, -28.5, 0.5);
  EXPECT_NEAR(end.needed_s, 2.05, 0.05);
}

TEST(ResponseEnd, SharpArrivalsCount) {
  PointResponse response;
  response.late = EnergyHistogram(100, kBin_s);
  response.arrivals.resize(2);
  response.arrivals[0].delay_s = 0.01;
  response.arrivals[0].gain = all_bands(1.0F);
  response.arrivals[1].delay_s = 0.19;
  response.arrivals[1].gain = all_bands(0.1F);
  const ResponseEnd end = response_end(response, 0.2);
  // Gains are floats: 1e-7 of a tenth.
  EXPECT_NEAR(end.level_db, -20.0, 1e-3);
}

TEST(ResponseEnd, SilenceHasNoLevel) {
  PointResponse response;
  response.late = EnergyHistogram(100, kBin_s);
  EXPECT_EQ(response_end(response, 0.2).level_db, -INFINITY);
}

}  // namespace
}  // namespace earpoint

#include <cmath>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/spatial/shoebox.h>

namespace earpoint {
namespace {

Shoebox room_of(const Vector3& lengths_m, float absorption) {
  Shoebox room;
  room.lengths_m = lengths_m;
  room.absorption.fill(all_bands(absorption));
  return room;
}

const Vector3 kSource{1.03, 2.011, 1.707};
const Pose kListener{{4.2173, 3.0931, 1.2117}, {}};

TEST(Shoebox, DirectSoundComesStraightAfterDistanceOverSpeedOfSound) {
  const Shoebox room = room_of({6, 5, 3}, 0.2F);
  const std::vector<Arrival> arrivals = shoebox_arrivals(room, kSource, kListener, 0.1);
  const Vector3 way = kSource - kListener.position_m;
  ASSERT_FALSE(arrivals.empty());
  EXPECT_EQ(arrivals[0].order, 0);
  EXPECT_NEAR(arrivals[0].delay_s, norm(way) / 343.2, 1e-12);
  EXPECT_NEAR(norm(arrivals[0].direction - normalized(way)), 0.0, 1e-12);
  EXPECT_NEAR(norm(arrivals[0].departure + normalized(way)), 0.0, 1e-12);
  // 1/r and the air at 500 Hz, 2.7 dB/km.
  EXPECT_NEAR(arrivals[0].gain[3],
              std::pow(10.0, -air_absorption_db_per_m(500.0, Air{}) * norm(way) / 20) / norm(way),
              1e-6);
}

TEST(Shoebox, FirstOrderReflectionsMirrorTheSourceInEachWall) {
  Shoebox room = room_of({6, 5, 3}, 0.0F);
  for (int wall = 0; wall < 6; ++wall)
    room.absorption[wall] = all_bands(0.1F * static_cast<float>(wall + 1));
  const std::vector<Arrival> arrivals = shoebox_arrivals(room, kSource, kListener, 0.1, 1);
  const auto [x, y, z] = kSource;
  const std::vector<Vector3> images = {{-x, y, z},     {12 - x, y, z}, {x, -y, z},
                                       {x, 10 - y, z}, {x, y, -z},     {x, y, 6 - z}};
  ASSERT_EQ(arrivals.size(), 7U);
  for (int wall = 0; wall < 6; ++wall) {
    const double distance_m = norm(images[wall] - kListener.position_m);
    int found = 0;
    for (const Arrival& arrival : arrivals) {
      if (std::abs(arrival.delay_s - distance_m / 343.2) > 1e-9) continue;
      ++found;
      const double expected = std::sqrt(1.0 - 0.1 * (wall + 1)) / distance_m *
                              air_gain(air_absorption_db_per_m(room.air), distance_m)[4];
      EXPECT_NEAR(arrival.gain[4], expected, 1e-6) << wall;
      EXPECT_NEAR(norm(arrival.direction - normalized(images[wall] - kListener.position_m)), 0.0,
                  1e-12);
      // The path from the source meets the wall where the path to the listener leaves it: both have
      // the same component along the wall and opposite ones across.
      EXPECT_NEAR(std::abs(arrival.departure.x), std::abs(arrival.direction.x), 1e-12);
    }
    EXPECT_EQ(found, 1) << wall;
  }
}

TEST(Shoebox, DeparturesLeaveTowardsTheWallThatReflects) {
  const std::vector<Arrival> arrivals =
      shoebox_arrivals(room_of({6, 5, 3}, 0.1F), kSource, kListener, 0.1, 1);
  ASSERT_EQ(arrivals.size(), 7U) << "straight, and by each of six walls";
  for (const Arrival& arrival : arrivals) {
    if (arrival.order == 0) continue;
    // A ray along the departure, mirrored at the walls, is at the listener at the time of arrival.
    Vector3 at = kSource + arrival.departure * (arrival.delay_s * 343.2);
    const auto fold = [](double x, double length) {
      x = std::fmod(std::fmod(x, 2 * length) + 2 * length, 2 * length);
      return x > length ? 2 * length - x : x;
    };
    at = {fold(at.x, 6), fold(at.y, 5), fold(at.z, 3)};
    EXPECT_NEAR(norm(at - kListener.position_m), 0.0, 1e-9);
  }
}

TEST(Shoebox, ArrivalsAreAsManyAsTheVolumeTellsAndInOrder) {
  const double time_s = 0.25;
  const std::vector<Arrival> arrivals =
      shoebox_arrivals(room_of({6, 5, 3}, 0.2F), kSource, kListener, time_s);
  const double sphere = 4.0 / 3.0 * kPi * std::pow(343.2 * time_s, 3.0);
  // One image per room volume; the surface of the sphere makes a difference of about 1 % at this
  // radius.
  EXPECT_NEAR(static_cast<double>(arrivals.size()) / (sphere / 90.0), 1.0, 0.02);
  for (std::size_t i = 1; i < arrivals.size(); ++i) {
    EXPECT_LE(arrivals[i - 1].delay_s, arrivals[i].delay_s);
  }
}

TEST(Shoebox, SwappingSourceAndListenerKeepsEveryArrival) {
  const Shoebox room = room_of({6, 5, 3}, 0.3F);
  const std::vector<Arrival> there = shoebox_arrivals(room, kSource, kListener, 0.1);
  const std::vector<Arrival> back =
      shoebox_arrivals(room, kListener.position_m, Pose{kSource, {}}, 0.1);
  ASSERT_EQ(there.size(), back.size());
  // Odd coordinates: no two arrivals come at the same time, so the order is the same.
  for (std::size_t i = 0; i < there.size(); ++i) {
    EXPECT_NEAR(there[i].delay_s, back[i].delay_s, 1e-12);
    EXPECT_NEAR(there[i].gain[2], back[i].gain[2], 1e-7);
  }
}

TEST(Shoebox, TurningTheHeadTurnsTheDirections) {
  const Shoebox room = room_of({6, 5, 3}, 0.3F);
  // Facing +y, the source at -x from the listener is to the left.
  Pose listener{{4.0, kSource.y, kSource.z}, quaternion_from_euler({.yaw_rad = kPi / 2})};
  const std::vector<Arrival> arrivals = shoebox_arrivals(room, kSource, listener, 0.05);
  EXPECT_NEAR(arrivals[0].direction.y, 1.0, 1e-12);
}

TEST(Shoebox, EnergyOfAClosedLosslessRoomGrowsWithoutDecay) {
  Shoebox room = room_of({5, 4, 3}, 0.0F);
  room.air = {.temperature_celsius = 20.0, .relative_humidity_percent = 100.0};
  const std::vector<Arrival> arrivals =
      shoebox_arrivals(room, {1, 1, 1}, Pose{{3, 2.5, 1.2}, {}}, 0.3);
  // At 62.5 Hz the air absorbs almost nothing. Energy per second in a lossless room tends to
  // 4 pi c / V.
  double energy = 0.0;
  for (const Arrival& arrival : arrivals) {
    if (arrival.delay_s > 0.1) energy += static_cast<double>(arrival.gain[0]) * arrival.gain[0];
  }
  // Images at the edges of the shell: within 3 %.
  EXPECT_NEAR(energy / 0.2 / (4.0 * kPi * 343.2 / 60.0), 1.0, 0.03);
}

TEST(Shoebox, EyringMatchesAHandComputedRoom) {
  Shoebox room = room_of({6, 5, 3}, 0.2F);
  // 24 ln10 / 343.2 * 90 / (126 * 0.22314 + 4 V m); at 62.5 Hz m is negligible: 0.5154 s.
  EXPECT_NEAR(eyring_reverberation_time_s(room)[0], 0.5154, 0.0005);
  EXPECT_LT(eyring_reverberation_time_s(room)[7], 0.45);
}

TEST(Shoebox, RefusesWhatIsNotARoom) {
  const Shoebox room = room_of({6, 5, 3}, 0.2F);
  EXPECT_THROW(static_cast<void>(shoebox_arrivals(room, {7, 1, 1}, kListener, 0.1)), InputError);
  EXPECT_THROW(static_cast<void>(shoebox_arrivals(room, kListener.position_m, kListener, 0.1)),
               InputError);
  EXPECT_THROW(
      static_cast<void>(shoebox_arrivals(room_of({6, 5, 3}, 1.2F), kSource, kListener, 0.1)),
      InputError);
  EXPECT_THROW(
      static_cast<void>(shoebox_arrivals(room_of({6, 0, 3}, 0.2F), kSource, kListener, 0.1)),
      InputError);
  EXPECT_THROW(static_cast<void>(shoebox_arrivals(room, kSource, kListener, 20.0)), InputError);
}

}  // namespace
}  // namespace earpoint

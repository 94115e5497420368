#include "diffraction_paths.h"

#include "gates/measurement.h"
#include "gates/rooms.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/spatial/air_absorption.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {
namespace {

using gates::add_block;
using gates::omni;

AcousticMaterial hard_wall() {
  return {.name = "wall",
          .absorption = all_bands(0.02F),
          .scattering = all_bands(0.0F),
          .transmission = {},
          .source = {}};
}

// 10 m along each axis, anechoic.
Scene dead_room() { return make_shoebox({10, 10, 10}, all_bands(1.0F), all_bands(0.0F)); }

// A wall of half the room's height.
Scene room_with_wall(double thickness_m) {
  Scene scene = dead_room();
  add_block(scene, {5, 0, 0}, {5 + thickness_m, 10, 5}, hard_wall());
  return scene;
}

std::vector<PointResponse> trace_all(const Scene& scene, const Vector3& source,
                                     const std::vector<Vector3>& listeners) {
  TraceOptions options{.rays = 100, .duration_s = 0.1, .air_absorbs = false};
  options.mirror_rays = 2000;
  const Source from = omni(source);
  ThreadPool pool(1);
  return trace(AcousticScene(scene), {&from, 1}, listeners, options, pool).responses[0];
}

// Relative to free field.
double level_db(const PointResponse& response, int band) {
  return gates::arrivals_level_db(response, band, speed_of_sound_m_per_s({})) +
         20.0 * std::log10(response.distance_m);
}

void expect_levels(const PointResponse& response, const std::array<double, 3>& wanted_db) {
  for (int i = 0; i < 3; ++i) {
    // 125, 250, 500 Hz. The wave solver's own error is a few tenths; 1 dB is just audible.
    EXPECT_NEAR(level_db(response, i + 1), wanted_db[i], 1.0) << kOctaveBandCentresHz[i + 1];
  }
}

// Levels are from a three-dimensional wave solver with rigid walls, written independently of this
// code.

TEST(DiffractionPaths, EndOfAThickWallIsAsLoudAsWavesAre) {
  const auto responses =
      trace_all(room_with_wall(0.1), {3, 5, 5.1}, {{7.3, 5, 5.3}, {7.3, 5, 4.95}});
  expect_levels(responses[0], {-3.5, -3.3, -2.9});
  expect_levels(responses[1], {-4.6, -4.9, -4.9});
}

TEST(DiffractionPaths, DoorwayInAThickWallIsAsLoudAsWavesAre) {
  Scene scene = dead_room();
  add_block(scene, {5, 0, 0}, {5.1, 4.55, 10}, hard_wall());
  add_block(scene, {5, 5.45, 0}, {5.1, 10, 10}, hard_wall());
  expect_levels(trace_all(scene, {2.5, 5, 5}, {{7, 5, 5.1}})[0], {-4.8, -2.5, -0.4});
}

void expect_smooth(const Scene& scene, const Vector3& source, const Vector3& start,
                   const Vector3& step, int count) {
  std::vector<Vector3> listeners;
  for (int i = 0; i < count; ++i) listeners.push_back(start + step * static_cast<double>(i));
  const auto responses = trace_all(scene, source, listeners);
  for (int band = 0; band < kOctaveBands; ++band) {
    for (int i = 1; i < count; ++i) {
      EXPECT_NEAR(level_db(responses[i], band), level_db(responses[i - 1], band), 0.5)
          << kOctaveBandCentresHz[band] << " Hz, step " << i;
    }
  }
}

// Steps of a millimetre across the planes of both faces of the wall's end and the shadow boundary
// between. 0.5 dB is half of what is just audible; 0.4 dB was measured
// (docs/adr/0008-diffraction.md).

TEST(DiffractionPaths, SteppingBehindAWallMakesNoJump) {
  for (const double thickness : {0.05, 0.3}) {
    for (const double source_z : {4.8, 5.0, 5.2}) {
      const double middle_z = 5.0 + (5.0 - source_z) * 2.3 / 2.0;
      for (const double z : {5.0, middle_z}) {
        expect_smooth(room_with_wall(thickness), {3, 5, source_z}, {7.3, 5, z - 0.02},
                      {0, 0, 0.001}, 41);
      }
    }
  }
}

TEST(DiffractionPaths, SteppingPastADoorsCornerMakesNoJump) {
  const Scene scene = gates::wall_with_door(gates::Door::open, 0.1);
  // Across the planes of jamb and lintel, and the shadow of the corner.
  expect_smooth(scene, {-2, -1, 1.1}, {1.5, 0.98, 1.3}, {0, 0.001, 0}, 41);
  expect_smooth(scene, {-2, 0.5, 1.1}, {1.5, 0.4, 1.98}, {0, 0, 0.001}, 41);
  expect_smooth(scene, {-2, -1, 1.1}, {1.5, 0.5, 2.4}, {0, 0, 0.001}, 61);
}

TEST(DiffractionPaths, HiddenPlacesAreQuieterThanFreeField) {
  std::vector<Vector3> listeners;
  for (double x = 5.5; x < 9.5; x += 0.4) {
    for (double z = 4.0; z < 5.05; z += 0.1) listeners.push_back({x, 5.1, z});
  }
  for (const double thickness : {0.05, 0.17, 0.3}) {
    const auto responses = trace_all(room_with_wall(thickness), {3.2, 5, 5.06}, listeners);
    for (const PointResponse& response : responses) {
      if (response.sees_source) continue;
      for (int band = 0; band < kOctaveBands; ++band) EXPECT_LT(level_db(response, band), 0.0);
    }
  }
}

TEST(DiffractionPaths, NarrowRevealReflects) {
  // The reveal of a door is 0.1 x 2 m, too small for image sources.
  const Scene scene = gates::wall_with_door(gates::Door::open, 0.1);
  const auto responses = trace_all(scene, {-1.0, 0.5, 1.0}, {{1.1, 0.5, 1.2}});
  int mirrored = 0;
  for (const Arrival& arrival : responses[0].arrivals) {
    if (arrival.order == 0) continue;
    ++mirrored;
    // Off either side, 0.5 m away, within some roundings of the scene's float32 (1.4e-7 m).
    EXPECT_NEAR(arrival.delay_s * speed_of_sound_m_per_s({}), std::hypot(2.1, 1.0, 0.2), 1e-6);
    EXPECT_NEAR(arrival.gain[4], 1.0 / std::hypot(2.1, 1.0, 0.2), 1e-6);
  }
  EXPECT_EQ(mirrored, 2);
}

}  // namespace
}  // namespace earpoint

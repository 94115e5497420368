#include "gates/rooms.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/error.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {
namespace {

using gates::add_block;
using gates::omni;
using gates::open_air;

AcousticMaterial material(float absorption, float scattering, float transmission = 0.0F) {
  return {.name = "test",
          .absorption = all_bands(absorption),
          .scattering = all_bands(scattering),
          .transmission = all_bands(transmission),
          .source = {}};
}

PointResponse trace_one(const Scene& scene, const Source& source, const Vector3& listener,
                        TraceOptions options = {}) {
  options.rays = std::min(options.rays, 2000);
  options.air_absorbs = false;
  ThreadPool pool(1);
  return trace(AcousticScene(scene), {&source, 1}, {&listener, 1}, options, pool).responses[0][0];
}

double late_energy(const PointResponse& response, int band) {
  double sum = 0.0;
  for (int bin = 0; bin < response.late.bins(); ++bin) {
    sum += static_cast<double>(response.late.bin_energy(bin)[band]);
  }
  return sum;
}

TEST(Tracer, DirectSoundArrivesFromItsDirectionAtItsTime) {
  const PointResponse response = trace_one(open_air(), omni({0, 0, 0}), {3, 4, 0});
  ASSERT_EQ(response.arrivals.size(), 1U);
  const Arrival& direct = response.arrivals[0];
  EXPECT_NEAR(direct.delay_s, 5.0 / 343.2, 1e-6);  // the speed at 20 degrees, to 0.01 m/s
  EXPECT_NEAR(direct.direction.x, -0.6, 1e-12);
  EXPECT_NEAR(direct.departure.y, 0.8, 1e-12);
  EXPECT_FLOAT_EQ(direct.gain[4], 0.2F);
  EXPECT_EQ(late_energy(response, 4), 0.0);
}

TEST(Tracer, FloorMirrorsTheSourceExactly) {
  Scene scene = open_air();
  add_block(scene, {-20, -20, -1}, {20, 20, 0}, material(0.36F, 0.0F));
  const PointResponse response = trace_one(scene, omni({0, 0, 1}), {4, 0, 2});
  ASSERT_EQ(response.arrivals.size(), 2U);
  const Arrival& reflected = response.arrivals[1];
  EXPECT_EQ(reflected.order, 1);
  // Image at (0, 0, -1): 5 m away.
  EXPECT_NEAR(reflected.delay_s, 5.0 / 343.2, 1e-6);
  EXPECT_NEAR(reflected.direction.z, -0.6, 1e-6);
  EXPECT_NEAR(reflected.departure.z, -0.6, 1e-4);  // the path is followed to 0.1 mm of the floor
  EXPECT_NEAR(reflected.gain[3], 0.8F / 5.0F, 1e-6);
}

TEST(Tracer, ScatteringMovesEnergyFromTheMirrorToTheLateField) {
  Scene smooth = open_air();
  add_block(smooth, {-20, -20, -1}, {20, 20, 0}, material(0.0F, 0.0F));
  Scene rough = open_air();
  add_block(rough, {-20, -20, -1}, {20, 20, 0}, material(0.0F, 1.0F));
  const PointResponse mirrored = trace_one(smooth, omni({0, 0, 1}), {2, 0, 1});
  const PointResponse scattered = trace_one(rough, omni({0, 0, 1}), {2, 0, 1}, {.rays = 2000});
  EXPECT_EQ(late_energy(mirrored, 3), 0.0);
  EXPECT_EQ(scattered.arrivals.size(), 1U);
  // Lambert's law, summed over a fine grid of the floor.
  double expected = 0.0;
  constexpr double kStep = 0.02;
  for (double x = -20.0; x < 20.0; x += kStep) {
    for (double y = -20.0; y < 20.0; y += kStep) {
      const double to_source = x * x + y * y + 1.0;
      const double to_listener = (x - 2.0) * (x - 2.0) + y * y + 1.0;
      // cos / d^2 falls in, cos / (pi d^2) goes out.
      expected += kStep * kStep / (to_source * std::sqrt(to_source)) /
                  (to_listener * std::sqrt(to_listener)) / kPi;
    }
  }
  // 2000 rays, of which half meet the floor: 3 %.
  EXPECT_NEAR(late_energy(scattered, 3) / expected, 1.0, 0.05);
}

TEST(Tracer, WallsPassWhatTheyTransmitAndNoMore) {
  Scene scene = open_air();
  add_block(scene, {1, -20, -20}, {1.1, 20, 20}, material(1.0F, 0.0F, 0.01F));
  // What comes round the wall's ends, over 40 m, is left out.
  const TraceOptions straight{.diffracts = false};
  const PointResponse response = trace_one(scene, omni({0, 0, 0}), {2, 0, 0}, straight);
  ASSERT_EQ(response.arrivals.size(), 1U);
  // Two faces of 1 % each: amplitude 0.1 x 0.1 at 2 m.
  EXPECT_NEAR(response.arrivals[0].gain[2], 0.5F * 0.01F, 1e-7);

  Scene opaque = open_air();
  add_block(opaque, {1, -20, -20}, {1.1, 20, 20}, material(1.0F, 0.0F));
  EXPECT_TRUE(trace_one(opaque, omni({0, 0, 0}), {2, 0, 0}, straight).arrivals.empty());
}

TEST(Tracer, TransmittedSoundIsScatteredBehindTheWallToo) {
  // Behind a wall that passes a quarter, a diffuse floor sends a sixteenth (two faces) of what it
  // sends without the wall.
  Scene open = open_air();
  add_block(open, {1, -20, -2}, {20, 20, -1}, material(0.0F, 1.0F));
  Scene walled = open;
  add_block(walled, {0.5, -45, -45}, {0.6, 45, 45}, material(1.0F, 0.0F, 0.25F));
  const TraceOptions options{.rays = 2000};
  const double without = late_energy(trace_one(open, omni({0, 0, 0}), {3, 0, 0}, options), 3);
  const double with = late_energy(trace_one(walled, omni({0, 0, 0}), {3, 0, 0}, options), 3);
  // The rays that pass are drawn: about 2000 / 4 / 16 of them. 20 %.
  EXPECT_NEAR(with * 16.0 / without, 1.0, 0.2);
}

TEST(Tracer, OwnBodyDoesNotShadowTheMouthButOthersDo) {
  Scene scene = open_air();
  add_block(scene, {-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}, material(1.0F, 0.0F));
  const auto body = static_cast<std::uint32_t>(scene.instances.size() - 1);
  scene.instances[body].kind = InstanceKind::person;
  Source mouth = omni({0, 0, 0});
  EXPECT_TRUE(trace_one(scene, mouth, {2, 0, 0}).arrivals.empty());
  mouth.body = body;
  EXPECT_EQ(trace_one(scene, mouth, {2, 0, 0}).arrivals.size(), 1U);
  // A second person in between is in the way.
  add_block(scene, {0.8, -0.2, -0.2}, {1.2, 0.2, 0.2}, material(1.0F, 0.0F));
  scene.instances.back().kind = InstanceKind::person;
  EXPECT_TRUE(trace_one(scene, mouth, {2, 0, 0}).arrivals.empty());
}

TEST(Tracer, DirectivityWeighsWhatLeavesTheSource) {
  // Loud in front (x of the source), a quarter of the energy to the left, silent behind and right.
  std::vector<BandArray> rows(2 * 4, all_bands(0.0F));
  for (int row = 0; row < 2; ++row) {
    rows[row * 4 + 2] = all_bands(1.0F);   // azimuth 0
    rows[row * 4 + 3] = all_bands(0.25F);  // azimuth 90
  }
  Source source = omni({0, 0, 0});
  source.directivity = Directivity(4, 2, rows);
  EXPECT_FLOAT_EQ(trace_one(open_air(), source, {1, 0, 0}).arrivals[0].gain[0], 1.0F);
  EXPECT_FLOAT_EQ(trace_one(open_air(), source, {0, 1, 0}).arrivals[0].gain[0], 0.5F);
  EXPECT_FLOAT_EQ(trace_one(open_air(), source, {-1, 0, 0}).arrivals[0].gain[0], 0.0F);
  // Turned to the left, the front looks along y.
  source.world_from_source.orientation = quaternion_from_euler({.yaw_rad = kPi / 2});
  EXPECT_FLOAT_EQ(trace_one(open_air(), source, {0, 1, 0}).arrivals[0].gain[0], 1.0F);
}

TEST(Tracer, ReverberationGetsTheMeanOfTheDirectivity) {
  // Walls that reflect all and scatter it: after some bounces nothing tells of the first direction.
  const Scene room = make_shoebox({5, 4, 3}, all_bands(0.02F), all_bands(1.0F));
  Source source = omni({1, 1, 1});
  const PointResponse omnidirectional = trace_one(room, source, {3, 3, 2});
  source.directivity = speech_directivity();
  const PointResponse speech = trace_one(room, source, {3, 3, 2});
  const BandArray mean = source.directivity.mean_energy();
  for (int band = 0; band < kOctaveBands; ++band) {
    double with = 0.0;
    double without = 0.0;
    for (int bin = speech.late.bins() / 4; bin < speech.late.bins(); ++bin) {
      with += static_cast<double>(speech.late.bin_energy(bin)[band]);
      without += static_cast<double>(omnidirectional.late.bin_energy(bin)[band]);
    }
    // The same rays with other weights: what is left of chance is about 1 %.
    EXPECT_NEAR(with / without, static_cast<double>(mean[band]),
                0.04 * static_cast<double>(mean[band]))
        << band;
  }
}

TEST(Tracer, SameDirectivityInAllDirectionsIsOmnidirectional) {
  const Scene room = make_shoebox({5, 4, 3}, all_bands(0.3F), all_bands(0.5F));
  Source source = omni({1, 1, 1});
  const double without = late_energy(trace_one(room, source, {3, 3, 2}), 4);
  source.directivity = Directivity(2, 2, std::vector<BandArray>(4, all_bands(1.0F)));
  EXPECT_DOUBLE_EQ(late_energy(trace_one(room, source, {3, 3, 2}), 4), without);
}

TEST(Tracer, SoundComesFromTheSideOfTheReflector) {
  Scene scene = open_air();
  add_block(scene, {-20, 5, -20}, {20, 6, 20}, material(0.0F, 1.0F));
  const PointResponse response = trace_one(scene, omni({0, 0, 0}), {2, 0, 0});
  for (int sector = 0; sector < kSectors; ++sector) {
    double energy = 0.0;
    for (int bin = 0; bin < response.late.bins(); ++bin) {
      energy += static_cast<double>(response.late.at(bin, sector)[3]);
    }
    // Sectors are about 40 degrees wide, so that one may reach over the border.
    if (sector_direction(sector).y < -0.5) {
      EXPECT_EQ(energy, 0.0) << sector;
    }
  }
  EXPECT_GT(late_energy(response, 3), 0.0);
}

TEST(Tracer, MeasuresWhatEscapes) {
  // A box that swallows all sound, without its ceiling.
  Scene scene = make_shoebox({6, 5, 3}, all_bands(1.0F), all_bands(1.0F));
  scene.mesh.triangles.resize(10);
  scene.mesh.triangle_material.resize(10);
  scene.mesh.triangle_instance.resize(10);
  const Source source = omni({3, 2.5, 1.5});
  const Vector3 listener{1, 1, 1};
  ThreadPool pool(1);
  const TraceResult open = trace(AcousticScene(scene), {&source, 1}, {&listener, 1},
                                 {.rays = 2000, .max_escape_fraction = 1.0}, pool);
  // The ceiling's solid angle, seen from below its middle; 2000 evenly spread rays.
  const double solid_angle = 4.0 * std::atan(6.0 * 5.0 / (3.0 * std::sqrt(9.0 + 36.0 + 25.0)));
  EXPECT_NEAR(open.escape_fraction[0], solid_angle / (4.0 * kPi), 0.005);
  EXPECT_THROW(trace(AcousticScene(scene), {&source, 1}, {&listener, 1}, {.rays = 2000}, pool),
               InputError);
}

}  // namespace
}  // namespace earpoint

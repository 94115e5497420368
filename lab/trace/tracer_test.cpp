#include "gates/rooms.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/error.h>
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
  // Lambert's law, summed over a fine grid on the floor.
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
  // Without diffraction around the wall's ends, over 40 m.
  const TraceOptions straight{.diffracts = false};
  const PointResponse response = trace_one(scene, omni({0, 0, 0}), {2, 0, 0}, straight);
  ASSERT_EQ(response.arrivals.size(), 1U);
  // One wall of two faces, one loss: 1 % of the energy at 2 m.
  EXPECT_NEAR(response.arrivals[0].gain[2], 0.5F * 0.1F, 1e-7);

  Scene panel = open_air();
  gates::add_panel(panel, {1, -20, -20}, {0, 40, 0}, {0, 0, 40}, material(1.0F, 0.0F, 0.01F));
  EXPECT_NEAR(trace_one(panel, omni({0, 0, 0}), {2, 0, 0}).arrivals[0].gain[2], 0.5F * 0.1F, 1e-7);

  // Two walls, half a metre apart, lose twice.
  Scene two = scene;
  add_block(two, {1.6, -20, -20}, {1.7, 20, 20}, material(1.0F, 0.0F, 0.01F));
  EXPECT_NEAR(trace_one(two, omni({0, 0, 0}), {2, 0, 0}).arrivals[0].gain[2], 0.5F * 0.01F, 1e-7);

  Scene opaque = open_air();
  add_block(opaque, {1, -20, -20}, {1.1, 20, 20}, material(1.0F, 0.0F));
  EXPECT_TRUE(trace_one(opaque, omni({0, 0, 0}), {2, 0, 0}, straight).arrivals.empty());
}

TEST(Tracer, TransmittedSoundIsScatteredBehindTheWallToo) {
  // Behind a wall that transmits a quarter, a diffuse floor scatters a quarter of the energy. The
  // wall's two faces count once.
  Scene open = open_air();
  add_block(open, {1, -20, -2}, {20, 20, -1}, material(0.0F, 1.0F));
  Scene walled = open;
  add_block(walled, {0.5, -45, -45}, {0.6, 45, 45}, material(1.0F, 0.0F, 0.25F));
  const TraceOptions options{.rays = 2000};
  const double without = late_energy(trace_one(open, omni({0, 0, 0}), {3, 0, 0}, options), 3);
  const double with = late_energy(trace_one(walled, omni({0, 0, 0}), {3, 0, 0}, options), 3);
  // Rays pass by chance: about 2000 / 4 / 4 of them, with a standard error of 9 %.
  EXPECT_NEAR(with * 4.0 / without, 1.0, 0.15);
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
  // Walls that scatter nearly all sound: after some bounces the first direction does not matter.
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
    // The same rays with other weights: the ratio has a standard error of about 1 %.
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
    // Sectors are about 40 degrees wide, so that one may extend across the border.
    if (sector_direction(sector).y < -0.5) {
      EXPECT_EQ(energy, 0.0) << sector;
    }
  }
  EXPECT_GT(late_energy(response, 3), 0.0);
}

TEST(Tracer, MeasuresWhatEscapes) {
  // A fully absorbing box without its ceiling.
  Scene scene = make_shoebox({6, 5, 3}, all_bands(1.0F), all_bands(1.0F));
  scene.mesh.triangles.resize(10);
  scene.mesh.triangle_material.resize(10);
  scene.mesh.triangle_instance.resize(10);
  const Source source = omni({3, 2.5, 1.5});
  const Vector3 listener{1, 1, 1};
  ThreadPool pool(1);
  const TraceResult open = trace(AcousticScene(scene), {&source, 1}, {&listener, 1},
                                 {.rays = 2000, .max_escape_fraction = 1.0}, pool);
  // The ceiling's solid angle, seen from below its middle; 2000 evenly spread rays, of which ten
  // more or fewer may pass its rim.
  const double solid_angle = 4.0 * std::atan(6.0 * 5.0 / (3.0 * std::sqrt(9.0 + 36.0 + 25.0)));
  EXPECT_NEAR(open.escape_fraction[0], solid_angle / (4.0 * kPi), 0.005);
  EXPECT_THROW(trace(AcousticScene(scene), {&source, 1}, {&listener, 1}, {.rays = 2000}, pool),
               InputError);
}

// A room of 8 x 4 x 3 m with a wall in its middle that ends before the ceiling.
Scene divided_room() {
  Scene scene = make_shoebox({8, 4, 3}, all_bands(0.2F), all_bands(0.3F));
  gates::add_panel(scene, {4, 0, 0}, {0, 4, 0}, {0, 0, 2}, material(0.2F, 0.1F));
  return scene;
}

TEST(Tracer, MirrorImagesAboutAWallHearEachOtherRoundIt) {
  const PointResponse response = trace_one(divided_room(), omni({2, 1, 1.5}), {6, 1, 1.5});
  EXPECT_FALSE(response.sees_source);
  EXPECT_GT(late_energy(response, 4), 0.0);
  for (const Arrival& arrival : response.arrivals) {
    EXPECT_GE(arrival.delay_s, 4.0 / 343.3);
    // No path is shorter than 4 m, and none is louder than in free field.
    for (const float gain : arrival.gain) EXPECT_LE(std::abs(gain), 0.25F);
  }
}

TEST(Tracer, RefusesASourceInTheListenersPlace) {
  const Scene room = make_shoebox({5, 4, 3}, all_bands(0.2F), all_bands(0.3F));
  EXPECT_THROW(trace_one(room, omni({1, 1, 1}), {1, 1, 1}), InputError);
  EXPECT_THROW(trace_one(room, omni({1, 1, 1}), {1, 1, 1.0005}), InputError);
}

// Places that may cause divisions by zero: in planes, on edges and corners, mirrored, equal.
class OddPlaces {
 public:
  explicit OddPlaces(const Mesh& mesh) : mesh_(mesh), random_(7) {}

  Vector3 next(const Vector3& other) {
    const auto& triangle = mesh_.triangles[random_.index(mesh_.triangles.size())];
    const Vector3 a = vertex(mesh_, triangle[0]);
    const Vector3 b = vertex(mesh_, triangle[1]);
    const Vector3 c = vertex(mesh_, triangle[2]);
    const double u = random_.uniform();
    switch (random_.index(7)) {
      case 0:
        return a;  // a corner
      case 1:
        return a + (b - a) * u;  // an edge
      case 2:
        return a + (b - a) * u + (c - a) * ((1.0 - u) * random_.uniform());  // a face
      case 3: {                                                              // a mirror image
        const Vector3 normal = normalized(cross(b - a, c - a));
        return other - normal * (2.0 * dot(normal, other - a));
      }
      case 4:
        return other;
      case 5:
        return other + Vector3{0.0, 0.0, 1e-9};
      default:
        return {random_.uniform(0.01, 7.99), random_.uniform(0.01, 3.99),
                random_.uniform(0.01, 2.99)};
    }
  }

 private:
  const Mesh& mesh_;
  RandomStream random_;
};

TEST(Tracer, TenThousandOddPairsGiveFiniteResponsesOrARefusal) {
  const Scene room = divided_room();
  const AcousticScene scene(room);
  OddPlaces places(room.mesh);
  ThreadPool pool(1);
  TraceOptions options{.rays = 8,
                       .max_bounces = 10,
                       .mirror_rays = 100,
                       .max_mirrors = 4,
                       .duration_s = 0.03,
                       .max_escape_fraction = 1.0};
  int refused = 0;
  for (int pair = 0; pair < 10'000; ++pair) {
    const Vector3 from = places.next({4.0, 2.0, 1.0});
    const Vector3 to = places.next(from);
    Source source = omni(from);
    if (pair % 2 == 0) source.directivity = speech_directivity();
    options.seed = static_cast<std::uint64_t>(pair);
    try {
      const TraceResult traced = trace(scene, {&source, 1}, {&to, 1}, options, pool);
      for (const Arrival& arrival : traced.responses[0][0].arrivals) {
        ASSERT_TRUE(std::isfinite(arrival.delay_s + norm(arrival.direction))) << pair;
        for (const float gain : arrival.gain) ASSERT_TRUE(std::isfinite(gain)) << pair;
      }
      ASSERT_TRUE(std::isfinite(late_energy(traced.responses[0][0], 3))) << pair;
    } catch (const InputError&) {
      ++refused;
      ASSERT_LT(norm(to - from), 1e-3);  // as trace() says
    }
  }
  // Two of seven kinds are refused, and sometimes the same corner twice.
  EXPECT_GT(refused, 2000);
}

std::string refusal_of(const Scene& scene, const Vector3& source_m) {
  try {
    trace_one(scene, omni(source_m), {2.1, 1.9, 1.3});
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Tracer, SaysWhySoundEscapes) {
  const Scene closed = make_shoebox({6, 5, 3}, all_bands(0.2F), all_bands(0.3F));
  EXPECT_NE(refusal_of(closed, {9, 2, 1}).find("is outside the walls"), std::string::npos);
  // Half of the rays from a wall's plane begin behind it, or all by rounding.
  EXPECT_NE(refusal_of(closed, {3, 2, 0}).find("the source: is on a surface"), std::string::npos)
      << refusal_of(closed, {3, 2, 0});
  Scene open = closed;
  open.mesh.triangles.resize(10);
  open.mesh.triangle_material.resize(10);
  open.mesh.triangle_instance.resize(10);
  for (const double z : {0.5, 1.5, 2.8}) {
    EXPECT_NE(refusal_of(open, {3, 2, z}).find("close the holes"), std::string::npos) << z;
  }
}

}  // namespace
}  // namespace earpoint

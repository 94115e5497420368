#include "propagation.h"
#include "ray_walk.h"
#include "specular_paths.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/core.h>

#include <earpoint/core/error.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {
namespace {

// Late energy is kept in bins of this width: finer than the ear's resolution of a tail, and than
// the 10 ms in which decays are judged.
constexpr double kBin_s = 0.002;

// The rays of a source are walked in this many shares, whatever the number of threads, and their
// energies are added in order: the sum's last bits do not depend on who was first.
constexpr int kShares = 8;

void check_options(const TraceOptions& options) {
  EARPOINT_CHECK(options.rays > 0 && options.max_bounces > 0);
  EARPOINT_CHECK(options.mirror_rays >= 0 && options.max_mirrors >= 0);
  EARPOINT_CHECK(options.duration_s > 0.0);
  EARPOINT_CHECK(options.max_escape_fraction >= 0.0 && options.max_escape_fraction <= 1.0);
  check_air(options.air);
}

// The straight way, through whatever lets sound through.
void add_direct(const SceneGeometry& scene, const Source& source, const Vector3& listener,
                const Propagation& propagation, PointResponse& response) {
  const Vector3& source_m = source.world_from_source.position_m;
  const Vector3 way = listener - source_m;
  response.distance_m = norm(way);
  EARPOINT_CHECK(response.distance_m > 0.0);
  const Vector3 departure = way / response.distance_m;
  BandArray energy = sent_energy(source, departure);
  if (!scene.transmit(source_m, listener, scene.mask_without(source.body), energy)) return;
  response.arrivals.insert(response.arrivals.begin(),
                           make_arrival(propagation, listener, source_m, departure, energy));
}

// How far mirror rays are trusted to find every image source: out to where an opening of this area
// catches three of them.
MirrorLimits mirror_limits(const TraceOptions& options, double speed_m_per_s) {
  constexpr double kOpening_m2 = 4.0;
  const double reach_m = std::sqrt(options.mirror_rays * kOpening_m2 / (3.0 * 4.0 * kPi));
  return {.max_reflections = options.mirror_rays > 0 ? options.max_mirrors : 0,
          .max_distance_m = std::min(reach_m, options.duration_s * speed_m_per_s),
          .min_energy = 1e-4,
          .min_purity = 0.03};
}

// All of a bin's energy has come the same way, within the width of the bin.
void absorb_in_air(const Propagation& propagation, EnergyHistogram& late) {
  for (int bin = 0; bin < late.bins(); ++bin) {
    const double distance_m = (bin + 0.5) * late.bin_s() * propagation.speed_m_per_s;
    const BandArray gain = air_gain(propagation.absorption_db_per_m, distance_m);
    for (int sector = 0; sector < kSectors; ++sector) {
      BandArray& energy = late.at(bin, sector);
      for (int band = 0; band < kOctaveBands; ++band) energy[band] *= gain[band] * gain[band];
    }
  }
}

void check_escape(double fraction, double limit) {
  if (fraction <= limit) return;
  throw InputError("the mesh",
                   fmt::format("leaks: {:.1f} % of the sound escapes through holes, expected at "
                               "most {:.1f} %",
                               100.0 * fraction, 100.0 * limit),
                   "close the holes, or trace it as open air");
}

// Walks the rays of all sources; adds the shares of each source up in order.
std::vector<WalkTally> walk_sources(const WalkSetup& setup, std::span<const Source> sources,
                                    ThreadPool& pool) {
  const std::int64_t rays = setup.options->rays;
  std::vector<WalkTally> shares(sources.size() * kShares);
  pool.run(std::ssize(shares), [&](std::ptrdiff_t task, int) {
    const auto source = static_cast<std::size_t>(task / kShares);
    const std::int64_t share = task % kShares;
    shares[task] = walk_rays(setup, {.source = &sources[source],
                                     .stream = source,
                                     .first_ray = static_cast<int>(share * rays / kShares),
                                     .last_ray = static_cast<int>((share + 1) * rays / kShares)});
  });
  std::vector<WalkTally> totals;
  for (std::size_t source = 0; source < sources.size(); ++source) {
    WalkTally& total = totals.emplace_back(std::move(shares[source * kShares]));
    for (int share = 1; share < kShares; ++share) {
      const WalkTally& tally = shares[source * kShares + share];
      total.emitted += tally.emitted;
      total.escaped += tally.escaped;
      total.rays_cast += tally.rays_cast;
      for (std::size_t i = 0; i < total.late.size(); ++i) total.late[i].add(tally.late[i]);
    }
  }
  return totals;
}

}  // namespace

TraceResult trace(const AcousticScene& scene, std::span<const Source> sources,
                  std::span<const Vector3> listeners, const TraceOptions& options,
                  ThreadPool& pool) {
  check_options(options);
  const SceneGeometry& geometry = scene.geometry();
  const Propagation propagation = make_propagation(options);
  WalkSetup setup{.scene = &geometry, .listeners = listeners, .options = &options};
  setup.mirrors = mirror_limits(options, propagation.speed_m_per_s);
  setup.bins = std::max(1, static_cast<int>(std::ceil(options.duration_s / kBin_s)));
  setup.bin_s = kBin_s;
  setup.bin_m = kBin_s * propagation.speed_m_per_s;
  std::vector<WalkTally> tallies = walk_sources(setup, sources, pool);

  TraceResult result;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    WalkTally& tally = tallies[i];
    result.escape_fraction.push_back(tally.emitted > 0.0 ? tally.escaped / tally.emitted : 0.0);
    check_escape(result.escape_fraction.back(), options.max_escape_fraction);
    result.rays_cast += tally.rays_cast;
    const std::vector<ImageSource> images =
        find_image_sources(geometry, sources[i], setup.mirrors, options.mirror_rays, pool);
    std::vector<PointResponse>& responses = result.responses.emplace_back(listeners.size());
    for (std::size_t j = 0; j < listeners.size(); ++j) {
      PointResponse& response = responses[j];
      response.arrivals = specular_arrivals(geometry, sources[i], listeners[j], images,
                                            setup.mirrors, propagation, pool, result.rays_cast);
      add_direct(geometry, sources[i], listeners[j], propagation, response);
      response.late = std::move(tally.late[j]);
      absorb_in_air(propagation, response.late);
    }
  }
  return result;
}

}  // namespace earpoint

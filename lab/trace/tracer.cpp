#include <earpoint/trace/tracer.h>

#include "diffraction_paths.h"
#include "escape_check.h"
#include "propagation.h"
#include "source_walk.h"
#include "specular_paths.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {
namespace {

// Width of the bins of late energy: finer than what is audible in a tail, and than the 10 ms
// windows for decays.
constexpr double kBin_s = 0.002;

void check_options(const TraceOptions& options) {
  EARPOINT_CHECK(options.rays > 0 && options.max_bounces > 0);
  EARPOINT_CHECK(options.mirror_rays >= 0 && options.max_mirrors >= 0);
  EARPOINT_CHECK(options.duration_s > 0.0);
  EARPOINT_CHECK(options.max_escape_fraction >= 0.0 && options.max_escape_fraction <= 1.0);
  check_air(options.air);
}

// Closer to a point source the level grows without limit.
void check_apart(std::span<const Source> sources, std::span<const Vector3> listeners) {
  constexpr double kLeast_m = 1e-3;
  for (const Source& source : sources) {
    for (const Vector3& listener : listeners) {
      if (norm(listener - source.world_from_source.position_m) >= kLeast_m) continue;
      throw InputError("listener", "is at the position of the source",
                       "move one of them by 1 mm or more");
    }
  }
}

// The straight path, through everything that transmits sound.
void add_direct(const SceneGeometry& scene, const Source& source, const Vector3& listener,
                const Propagation& propagation, PointResponse& response) {
  const Vector3& source_m = source.world_from_source.position_m;
  const Vector3 way = listener - source_m;
  response.distance_m = norm(way);
  const Vector3 departure = way / response.distance_m;
  BandArray energy = sent_energy(source, departure);
  if (!scene.transmit(source_m, listener, scene.mask_without(source.body), energy)) return;
  response.arrivals.push_back(make_arrival(propagation, listener, source_m, departure, energy));
  response.sees_source = true;
}

// Discrete arrivals of one source at all listeners.
class ArrivalFinder {
 public:
  ArrivalFinder(const SceneGeometry& scene, std::span<const Vector3> listeners,
                const TraceOptions& options, const MirrorLimits& mirrors)
      : scene_(scene),
        options_(options),
        mirrors_(mirrors),
        propagation_(make_propagation(options)),
        listeners_(listeners) {
    if (!options.diffracts) return;
    for (const Vector3& listener : listeners) {
      views_.emplace_back(scene, listener, kAllLayers, rays_cast_);
    }
  }

  void find(const Source& source, ThreadPool& pool, std::vector<PointResponse>& responses) {
    const std::vector<ImageSource> images =
        find_image_sources(scene_, source, mirrors_, options_.mirror_rays, pool, rays_cast_);
    std::optional<EdgeView> from;
    if (options_.diffracts) {
      from.emplace(scene_, source.world_from_source.position_m, scene_.mask_without(source.body),
                   rays_cast_);
    }
    for (std::size_t i = 0; i < listeners_.size(); ++i) {
      PointResponse& response = responses[i];
      response.arrivals = specular_arrivals(scene_, source, listeners_[i], images, mirrors_,
                                            propagation_, pool, rays_cast_);
      add_direct(scene_, source, listeners_[i], propagation_, response);
      if (from) {
        const std::vector<Arrival> round =
            diffracted_arrivals(scene_, source, *from, views_[i], response.arrivals, propagation_);
        response.arrivals.insert(response.arrivals.end(), round.begin(), round.end());
      }
      std::stable_sort(response.arrivals.begin(), response.arrivals.end(),
                       [](const Arrival& a, const Arrival& b) { return a.delay_s < b.delay_s; });
    }
  }

  [[nodiscard]] std::int64_t rays_cast() const { return rays_cast_; }

 private:
  const SceneGeometry& scene_;
  const TraceOptions& options_;
  const MirrorLimits& mirrors_;
  Propagation propagation_;
  std::span<const Vector3> listeners_;
  std::vector<EdgeView> views_;
  std::int64_t rays_cast_ = 0;
};

// Distance up to which mirror rays find every image source: where an opening of this area catches
// three of them.
MirrorLimits mirror_limits(const TraceOptions& options, double speed_m_per_s) {
  constexpr double kOpeningSquareMetres = 4.0;
  const double reach_m = std::sqrt(options.mirror_rays * kOpeningSquareMetres / (3.0 * 4.0 * kPi));
  return {.max_reflections = options.mirror_rays > 0 ? options.max_mirrors : 0,
          .max_distance_m = std::min(reach_m, options.duration_s * speed_m_per_s),
          .min_energy = 1e-5,
          .min_purity = 0.03};
}

// All energy of a bin has travelled the same distance, to within the width of the bin.
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

}  // namespace

TraceResult trace(const AcousticScene& scene, std::span<const Source> sources,
                  std::span<const Vector3> listeners, const TraceOptions& options,
                  ThreadPool& pool) {
  check_options(options);
  check_apart(sources, listeners);
  const SceneGeometry& geometry = scene.geometry();
  const Propagation propagation = make_propagation(options);
  WalkSetup setup{
      .scene = &geometry, .listeners = listeners, .options = &options, .rays = options.rays};
  setup.mirrors = mirror_limits(options, propagation.speed_m_per_s);
  setup.bins = std::max(1, static_cast<int>(std::ceil(options.duration_s / kBin_s)));
  setup.bin_s = kBin_s;
  setup.bin_m = kBin_s * propagation.speed_m_per_s;
  std::vector<WalkTally> tallies = walk_sources(setup, sources, pool);

  TraceResult result;
  ArrivalFinder finder(geometry, listeners, options, setup.mirrors);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    WalkTally& tally = tallies[i];
    // Rays after thinning represent several, so that the sum may slightly exceed 1.
    result.escape_fraction.push_back(
        tally.emitted > 0.0 ? std::min(1.0, tally.escaped / tally.emitted) : 0.0);
    check_escape(geometry, sources[i].world_from_source.position_m, result.escape_fraction.back(),
                 options.max_escape_fraction);
    result.rays_cast += tally.rays_cast;
    std::vector<PointResponse>& responses = result.responses.emplace_back(listeners.size());
    finder.find(sources[i], pool, responses);
    for (std::size_t j = 0; j < listeners.size(); ++j) {
      responses[j].late = std::move(tally.late[j]);
      absorb_in_air(propagation, responses[j].late);
    }
  }
  result.rays_cast += finder.rays_cast();
  return result;
}

}  // namespace earpoint

#pragma once

#include "mirror_chain.h"
#include "scene_geometry.h"

#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/trace/tracer.h>

namespace earpoint {

/// How much of a source's energy is still under way, at places `kAliveStep_m` of travel apart:
/// all rays together, per band.
constexpr double kAliveStep_m = 2.0;
using EnergyAlive = std::vector<BandArray>;

/// What a share of a source's rays brought about.
struct WalkTally {
  EnergyAlive alive;                  ///< filled by a survey alone
  std::vector<double> alive_squares;  ///< for each of them, the squares of single rays' energies
  std::vector<EnergyHistogram> late;  ///< [listener], without the air's absorption
  double emitted = 0.0;               ///< energy, summed over bands
  double escaped = 0.0;
  std::int64_t rays_cast = 0;
};

/// A share of the rays of one source.
struct WalkTask {
  const Source* source = nullptr;
  std::uint64_t stream = 0;  ///< the source's random stream
  int first_ray = 0;
  int last_ray = 0;  ///< one past the end
  /// The result of a survey, which gives the energy that a ray should carry: rays with much more
  /// are split, of those with less a few go on with more. Null where nothing is known yet.
  const EnergyAlive* expected = nullptr;
};

/// Everything that a walk reads.
struct WalkSetup {
  const SceneGeometry* scene = nullptr;
  std::span<const Vector3> listeners{};
  const TraceOptions* options = nullptr;
  int rays = 0;         ///< of every source, > 0
  bool survey = false;  ///< to fill in `WalkTally::alive`
  MirrorLimits mirrors{};
  double bin_s = 0.0;  ///< width of a bin of the histograms
  double bin_m = 0.0;  ///< the same as a distance
  int bins = 0;
};

/// Sends rays on random walks from surface to surface. At every bounce the diffuse share goes
/// straight to each listener that sees the place (next-event estimation); the ray goes on as one of
/// specular, diffuse or transmitted, drawn by the energy in each. What would reach a listener off a
/// mirror cannot be connected that way; it is counted when the ray passes through a small sphere
/// around the listener.
///
/// Where some walls swallow much more than others, late sound is that of the few rays that missed
/// them. So that it is not left to a handful, rays are split and thinned out to carry about as much
/// energy as the mean of all that left the source (weight windows; unbiased, whatever is expected).
WalkTally walk_rays(const WalkSetup& setup, const WalkTask& task);

}  // namespace earpoint

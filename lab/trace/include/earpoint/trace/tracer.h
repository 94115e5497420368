#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/core/parallel.h>
#include <earpoint/spatial/air_absorption.h>
#include <earpoint/spatial/arrival.h>
#include <earpoint/trace/acoustic_scene.h>
#include <earpoint/trace/energy_histogram.h>
#include <earpoint/trace/source.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// How a scene is traced.
struct TraceOptions {
  int rays = 5000;          ///< that leave each source, > 0
  int max_bounces = 1000;   ///< of a ray, > 0; most end earlier, by time or energy
  int mirror_rays = 20000;  ///< that look for image sources, >= 0
  int max_mirrors = 60;     ///< reflections of an image source, >= 0
  /// Whether sound bends round edges on its straight way: round one, or both of a wall's end. Long
  /// edges of walls, doors and furniture alone; what reflections bring is not diffracted.
  bool diffracts = true;
  double duration_s = 1.0;            ///< of the response, > 0
  std::uint64_t seed = 1;             ///< the same seed gives the same bytes
  Air air{};                          ///< its speed of sound and absorption
  bool air_absorbs = true;            ///< false: the air carries sound without loss
  double max_escape_fraction = 0.01;  ///< more than this and the mesh is refused; 1 for open air
};

/// The sound of one source at one listener: sharp arrivals, and the energy of all the rest. No
/// sound is in both.
struct PointResponse {
  double distance_m = 0.0;   ///< straight from source to listener
  bool sees_source = false;  ///< whether the straight way is free, or through what transmits
  /// Sound along sharp paths, by delay; its directions are in the world's frame.
  std::vector<Arrival> arrivals;
  EnergyHistogram late;
};

/// The responses of all pairs of a source and a listener.
struct TraceResult {
  std::vector<std::vector<PointResponse>> responses;  ///< [source][listener]
  /// [source] the share of the emitted energy that left the scene through holes, mean over bands.
  /// A hole acts as an absorber: reverberation is about this share too short.
  std::vector<double> escape_fraction;
  std::int64_t rays_cast = 0;  ///< towards surfaces and listeners, together
};

/// Traces sound from every source to every listener, source-centred: one bundle of rays per source
/// serves all listeners.
/// @param listeners  positions; the head's turn comes later (`ResponseSynthesizer`)
/// @throws InputError if more than `max_escape_fraction` of the energy escapes, a listener is less
///         than 1 mm from a source, or the air is out of range
/// @throws std::logic_error if an option is out of range
TraceResult trace(const AcousticScene& scene, std::span<const Source> sources,
                  std::span<const Vector3> listeners, const TraceOptions& options,
                  ThreadPool& pool);

}  // namespace earpoint

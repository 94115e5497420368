#pragma once

#include "mirror_chain.h"
#include "propagation.h"
#include "scene_geometry.h"

#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/trace/tracer.h>

namespace earpoint {

/// A mirror image of a source that some ray came upon.
struct ImageSource {
  Vector3 position_m;
  int reflections = 0;
};

/// Finds image sources by sending rays and reflecting them off mirrors only. An image is found when
/// a ray passes through a place where it could be heard; whether a listener does hear it,
/// `specular_arrivals` decides exactly.
/// @param rays  evenly spread; the more, the smaller the openings through which an image is found
/// @param rays_cast  counts on
/// @return  without duplicates, in an order that depends on nothing but the arguments
std::vector<ImageSource> find_image_sources(const SceneGeometry& scene, const Source& source,
                                            const MirrorLimits& limits, int rays, ThreadPool& pool,
                                            std::int64_t& rays_cast);

/// Follows the path from the listener back to the source, exactly: each image source that the
/// listener sees through the mirrors gives one arrival at its exact time and level, its direction
/// in the world's frame.
/// @return  by delay, without duplicates
std::vector<Arrival> specular_arrivals(const SceneGeometry& scene, const Source& source,
                                       const Vector3& listener, std::span<const ImageSource> images,
                                       const MirrorLimits& limits, const Propagation& propagation,
                                       ThreadPool& pool, std::int64_t& rays_cast);

}  // namespace earpoint

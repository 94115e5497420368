#pragma once

#include "ray_tracer.h"
#include "surfaces.h"

#include <vector>

#include <earpoint/scene/scene.h>

namespace earpoint {

/// The lamps of a scene. One without any, and without shining surfaces, gets them under its
/// ceilings, one every few metres, if wanted: scans have no lamps.
/// @return  never more than a few hundred
std::vector<Lamp> lamps_of(const Scene& scene, const Surfaces& surfaces, const RayTracer& tracer,
                           bool light_dark_scenes);

}  // namespace earpoint

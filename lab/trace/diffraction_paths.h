#pragma once

#include "edge_view.h"
#include "propagation.h"
#include "scene_geometry.h"

#include <span>
#include <vector>

#include <earpoint/trace/tracer.h>

namespace earpoint {

/// Sound that bends round one edge on its way, or round the two edges of a thick wall's end.
/// Where nothing is in the straight way, only edges close to it matter.
/// @param mirrored  what arrives straight or off mirrors (`order` > 0); edges take from it or add
///                  to it, and faces between edges that are not among it are added
/// @return  arrivals, directions in the world's frame
std::vector<Arrival> diffracted_arrivals(const SceneGeometry& scene, const Source& source,
                                         const EdgeView& from, const EdgeView& to,
                                         std::span<const Arrival> mirrored,
                                         const Propagation& propagation);

}  // namespace earpoint

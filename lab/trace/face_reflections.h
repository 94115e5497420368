#pragma once

#include "edge_view.h"
#include "propagation.h"
#include "scene_geometry.h"

#include <span>
#include <vector>

#include <earpoint/trace/tracer.h>

namespace earpoint {

/// Reflections off the faces between pairs of edges. Diffraction at both ends of a face counts on
/// its reflection, however narrow it is; image sources leave out planes below a quarter of a square
/// metre, and may miss a face that few rays meet. (The random walk brings the energy of narrow
/// faces to the late field too: that of a door's reveal.)
/// @param others  image sources' arrivals: what is among them is left out
/// @return  arrivals, directions in the world's frame
std::vector<Arrival> face_reflections(const SceneGeometry& scene, const Source& source,
                                      const EdgeView& from, const EdgeView& to,
                                      std::span<const Arrival> others,
                                      const Propagation& propagation);

/// @return whether one of the arrivals has come this far off a mirror
bool is_mirrored(std::span<const Arrival> arrivals, double distance_m, double speed_m_per_s);

}  // namespace earpoint

#pragma once

#include <cstddef>
#include <cstdint>

#include <earpoint/scene/material.h>
#include <earpoint/scene/scene.h>

namespace earpoint {

/// How tight a scene is. Sound that leaves through a hole is lost: leaky meshes shorten
/// reverberation.
struct Closure {
  std::size_t rays = 0;            ///< sent; 0 if no place inside was found
  double escaping_share = 0.0;     ///< of the rays: hit nothing
  double escaping_up_share = 0.0;  ///< of the rays: hit nothing and went up steeper than 30 degrees
  std::size_t open_edges = 0;      ///< belong to one face only
  double open_edges_m = 0.0;       ///< their length, together
};

/// Sends rays in all directions from places that have a floor below and walls around them, and
/// counts edges that belong to one face. Corners within 0.1 mm count as one.
/// @param scene  checked with check_scene
Closure check_closure(const Scene& scene, std::uint64_t seed = 1);

/// Puts a ceiling over every part of the scene that has a floor but nothing overhead: a lid at the
/// height of the highest wall around that part, and walls from the lid's rim down to what is below.
/// Works on a grid of 0.1 m (coarser for large scenes).
/// @param material  of the lid
/// @return the area of new ceiling in m2; 0 if nothing was open
double close_ceiling(Scene& scene, const Material& material);

}  // namespace earpoint

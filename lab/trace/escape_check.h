#pragma once

#include "scene_geometry.h"

namespace earpoint {

/// Refuses a scene out of which too much of a source's sound escapes, and says why as far as rays
/// can detect: the source is on a surface or outside, or the mesh has holes.
/// @param fraction  of the energy that escaped
/// @param limit     the most that may
/// @throws InputError
void check_escape(const SceneGeometry& scene, const Vector3& source_m, double fraction,
                  double limit);

}  // namespace earpoint

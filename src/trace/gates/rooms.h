#pragma once

#include <earpoint/scene/scene.h>
#include <earpoint/trace/tracer.h>

namespace earpoint::gates {

Source omni(const Vector3& position_m);

/// Adds a closed box, seen from outside.
void add_block(Scene& scene, const Vector3& low, const Vector3& high,
               const AcousticMaterial& material);

/// Nothing but walls that swallow all sound, far away.
Scene open_air();

/// 6 x 5 x 3 m, six different walls, a floor-to-ceiling partition between (2, 2) and (4.5, 2.2) m.
Scene obstacle_room();

}  // namespace earpoint::gates

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

/// Adds a flat parallelogram without thickness.
void add_panel(Scene& scene, const Vector3& corner, const Vector3& along, const Vector3& up,
               const AcousticMaterial& material);

enum class Door { none, open, closed };

/// Open air with a wall of 60 x 60 m in the plane x = 0, rigid and smooth, with a door at
/// y = 0 to 1, z = 0 to 2 m: open, closed by a panel that passes 1/3000 of the energy, or neither
/// door nor wall.
/// @param thickness_m  0 for a wall without thickness; otherwise from x = 0 on
Scene wall_with_door(Door door, double thickness_m = 0.0);

/// 6 x 5 x 3 m, six different walls, a floor-to-ceiling partition between (2, 2) and (4.5, 2.2) m.
Scene obstacle_room();

}  // namespace earpoint::gates

#pragma once

#include "home_shell.h"

#include <earpoint/core/random.h>
#include <earpoint/scene/floor_plan.h>

namespace earpoint {

/// Draws what walls, floors and ceilings are made of, room by room, and adds it to the scene.
/// @param softness  0 hard, 1 soft, as in HomeOptions
HomeFinish draw_home_finish(const FloorPlan& plan, double softness, RandomStream& random,
                            SceneBuilder& builder);

}  // namespace earpoint

#pragma once

#include <vector>

#include <earpoint/scene/floor_plan.h>
#include <earpoint/scene/scene_builder.h>

namespace earpoint {

/// The surfaces of one room.
struct RoomFinish {
  Surface floor;
  Surface wall;
  Surface ceiling;
};

/// The surfaces of a home. `door`, `front_door` and `pane` carry one picture of the whole thing.
struct HomeFinish {
  std::vector<RoomFinish> rooms;  ///< as FloorPlan::rooms
  Surface door;
  Surface front_door;
  Surface frame;  ///< the sides of doorways
  Surface pane;
  Surface reveal;  ///< the sides of window recesses
};

/// Adds the inside of all walls, floors and ceilings as one closed surface, faces towards the air.
///
/// Space is cut into cells along every plane of the plan; a face stands wherever air meets wall.
/// So each edge belongs to two faces (to three or four at the rim of a closed door, whose leaf is a
/// single sheet that sound may pass through), and no ray can slip between faces.
void add_shell(const FloorPlan& plan, const HomeFinish& finish, SceneBuilder& builder);

/// Adds a skirting board along every wall but those of baths, from doorway to doorway.
void add_skirting(const FloorPlan& plan, const HomeFinish& finish, SceneBuilder& builder);

/// Adds the leaves of open doors as boxes of their own, and frames to windows.
void add_leaves_and_frames(const FloorPlan& plan, const HomeFinish& finish, SceneBuilder& builder);

}  // namespace earpoint

#pragma once

#include <optional>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/generate/conversation.h>
#include <earpoint/pose.h>

namespace earpoint {

/// Cameras in a ring around a free part of the floor.
struct CameraRing {
  FloorPoint centre;
  double least_radius_m = 0.0;  ///< of the nearest camera
  std::vector<Pose> world_from_camera;
};

/// Looks for the place with the widest ring: every camera as far out as the room lets it, up to
/// 3.2 m, in even steps of angle, where it stands free and sees the middle.
/// @return nothing if no place has room for cameras 1.2 m away
std::optional<CameraRing> place_cameras(const PreparedScene& scene, int cameras,
                                        RandomStream& random);

}  // namespace earpoint

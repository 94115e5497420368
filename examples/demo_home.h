#pragma once

#include <string>
#include <vector>

#include <earpoint/camera/camera.h>
#include <earpoint/camera/scene_drawer.h>
#include <earpoint/core/parallel.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/scene/people.h>
#include <earpoint/scene/scene.h>

namespace earpoint {

/// The home of the bundled clip, the person who speaks in it, and the camera. Everything is drawn
/// from seeds with the furniture and people of `./dev assets`.
struct DemoHome {
  Scene scene;
  Person speaker;
  Camera camera;
};

/// @throws InputError if furniture and people are not installed
[[nodiscard]] DemoHome make_demo_home();

/// A place where the clip's sound is known, in the camera's frame: whole centimetres and degrees,
/// as earpoints.json has them.
struct DemoEarpoint {
  std::string name;
  Pose source_from_target;
  double yaw_deg = 0.0;  ///< the same turn as in the pose
};
[[nodiscard]] std::vector<DemoEarpoint> demo_earpoints(const DemoHome& home);

/// The home from above without its ceilings, turned so that the camera's front is up.
struct FloorMapPicture {
  Image rgb;
  PixelPosition camera;  ///< where it stands
  double pixels_per_metre = 0.0;
};
[[nodiscard]] FloorMapPicture picture_from_above(const DemoHome& home, ThreadPool& pool);

}  // namespace earpoint

#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/image.h>
#include <earpoint/record/session_truth.h>
#include <earpoint/record_simulation/session_plan.h>

namespace earpoint {

/// How the cameras of a session see.
struct SessionPictureQuality {
  int width = 480;   ///< pixels
  int height = 270;  ///< pixels
  double horizontal_fov_rad = radians_from_degrees(80.0);
  int samples_per_side = 2;  ///< its square per pixel
};

/// One picture of one camera.
struct SessionFrame {
  int camera = 0;
  int frame = 0;  ///< of this camera, from 0; shown from frame / frame rate on on its clock
  Image rgb;
  std::vector<PersonBox> boxes;  ///< of those whose body is in the picture
};

/// How many pictures a camera takes.
int frames_of(const SessionPlan& plan, int camera, double frame_rate_hz);

/// Takes the pictures of all cameras. A picture is a moment of session time that all cameras share:
/// it is at most 10 ms (the camera's offset past a multiple of the time between pictures) and the
/// clock's drift away from where its own clock says. Each camera keeps one exposure; a picture is
/// traced anew only around those who have moved since the last. People shift their weight where
/// they stand, and swing while they speak; the truth's tracks do not follow that.
/// @param sink  called in order of time, then of camera
/// @param jobs  threads; have no effect on the pictures
void film_session(const PreparedScene& scene, const SessionPlan& plan, double frame_rate_hz,
                  const SessionPictureQuality& quality, std::uint64_t seed, int jobs,
                  ProgressSink& progress, const std::function<void(const SessionFrame&)>& sink);

}  // namespace earpoint

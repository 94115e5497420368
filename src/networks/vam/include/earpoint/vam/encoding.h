#pragma once

#include <vector>

#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/vam/description.h>

namespace earpoint {

// What a visual acoustic matching network is given: for its engine and for training alike.

/// @param picture  sRGB, three channels
/// @return [3][image_height_px][image_width_px], 0 to 1
[[nodiscard]] std::vector<float> vam_picture(const VamDescription& description,
                                             const Image& picture);

/// Position in metres and turn of the target. @return [VamDescription::kPoseWidth]
[[nodiscard]] std::vector<float> vam_pose(const Pose& source_from_target);

}  // namespace earpoint

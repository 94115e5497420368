#pragma once

#include <vector>

#include <earpoint/pose.h>

namespace earpoint {

// What a visual acoustic matching network is given: for its engine and for training alike.

/// Position in metres and turn of the target. @return [VamDescription::kPoseWidth]
[[nodiscard]] std::vector<float> vam_pose(const Pose& source_from_target);

}  // namespace earpoint

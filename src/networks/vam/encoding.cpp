#include <earpoint/vam/encoding.h>

#include <utility>

#include <earpoint/network/pose_encoding.h>

namespace earpoint {

std::vector<float> vam_pose(const Pose& source_from_target) {
  EncodedPose pose = encode_pose(PoseEncoding::full, source_from_target);
  std::vector<float> both = std::move(pose.tgt_pose);
  both.insert(both.end(), pose.tgt_rotation.begin(), pose.tgt_rotation.end());
  return both;
}

}  // namespace earpoint

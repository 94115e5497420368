#include <earpoint/vam/encoding.h>

#include <utility>

#include <earpoint/core/resize.h>
#include <earpoint/error.h>
#include <earpoint/network/pose_encoding.h>

namespace earpoint {

std::vector<float> vam_picture(const VamDescription& description, const Image& picture) {
  EARPOINT_CHECK(picture.channels() == 3 && !picture.empty());
  ImagePlanes planes =
      resize_bilinear(planes_of(picture), description.image_width_px, description.image_height_px);
  for (float& value : planes.values) value /= 255.0F;
  return std::move(planes.values);
}

std::vector<float> vam_pose(const Pose& source_from_target) {
  EncodedPose pose = encode_pose(PoseEncoding::full, source_from_target);
  std::vector<float> both = std::move(pose.tgt_pose);
  both.insert(both.end(), pose.tgt_rotation.begin(), pose.tgt_rotation.end());
  return both;
}

}  // namespace earpoint

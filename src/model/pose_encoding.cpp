#include <cmath>

#include <earpoint/core/error.h>
#include <earpoint/model/pose_encoding.h>

namespace earpoint {
namespace {

constexpr double kCentimetresPerMetre = 100.0;

void append_sine_cosine(std::vector<float>& values, double angle_rad) {
  values.push_back(static_cast<float>(std::sin(angle_rad)));
  values.push_back(static_cast<float>(std::cos(angle_rad)));
}

std::vector<float> to_floats(std::initializer_list<double> values) {
  std::vector<float> floats;
  for (const double value : values) floats.push_back(static_cast<float>(value));
  return floats;
}

EncodedPose encode_soundspaces(const Pose& pose) {
  const Vector3& p = pose.position_m;
  const double azimuth_rad = p.x == 0.0 && p.y == 0.0 ? 0.0 : std::atan2(p.y, p.x);
  EncodedPose encoded;
  encoded.tgt_pose = to_floats({std::hypot(p.x, p.y)});
  append_sine_cosine(encoded.tgt_pose, azimuth_rad);
  append_sine_cosine(encoded.tgt_rotation, euler_from_quaternion(pose.orientation).yaw_rad);
  return encoded;
}

EncodedPose encode_replay(const Pose& pose) {
  const Vector3& p = pose.position_m;
  const double distance = kCentimetresPerMetre * std::hypot(p.x, p.y);
  const double turned_rad = 90.0 + std::atan2(p.y, p.x);
  const Vector3 front = rotate(pose.orientation, {1, 0, 0});
  EncodedPose encoded;
  encoded.tgt_pose = to_floats({distance * std::cos(turned_rad), distance * std::sin(turned_rad),
                                kCentimetresPerMetre * p.z});
  // The source looks along x: its own three angles are zero.
  append_sine_cosine(encoded.tgt_rotation, std::atan2(front.y, front.x));
  append_sine_cosine(encoded.tgt_rotation, std::atan2(front.z, front.y));
  append_sine_cosine(encoded.tgt_rotation, std::atan2(front.z, front.x));
  return encoded;
}

EncodedPose encode_full(const Pose& pose) {
  const Vector3& p = pose.position_m;
  const EulerAngles angles = euler_from_quaternion(pose.orientation);
  EncodedPose encoded;
  encoded.tgt_pose = to_floats({p.x, p.y, p.z});
  append_sine_cosine(encoded.tgt_rotation, angles.yaw_rad);
  append_sine_cosine(encoded.tgt_rotation, angles.pitch_rad);
  append_sine_cosine(encoded.tgt_rotation, angles.roll_rad);
  return encoded;
}

}  // namespace

EncodedPose encode_pose(PoseEncoding encoding, const Pose& source_from_target) {
  switch (encoding) {
    case PoseEncoding::soundspaces:
      return encode_soundspaces(source_from_target);
    case PoseEncoding::replay:
      return encode_replay(source_from_target);
    case PoseEncoding::full:
      return encode_full(source_from_target);
  }
  EARPOINT_CHECK(false);
}

std::vector<float> encode_box(BoxEncoding encoding, const Box& box) {
  switch (encoding) {
    case BoxEncoding::soundspaces:
      return to_floats({box.y_min, box.y_max, box.x_min, box.x_max});
    case BoxEncoding::corners:
      return to_floats({box.x_min, box.y_min, box.x_max, box.y_max});
    case BoxEncoding::centre: {
      const double height = box.y_max - box.y_min;
      if (height <= 0.0) return std::vector<float>(4);
      return to_floats({1.0, 2.0 * (box.x_min + box.x_max - 1.0),
                        2.0 * (box.y_min + box.y_max - 1.0), 2.0 * std::log(2.0 * height)});
    }
  }
  EARPOINT_CHECK(false);
}

std::vector<float> encode_box(BoxEncoding encoding, const std::optional<Box>& box) {
  return encode_box(encoding, box.value_or(Box{}));
}

}  // namespace earpoint

#include <earpoint/network/pose_encoding.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <earpoint/error.h>

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

/// Rounding of a pose must not decide between 0 and pi where an angle's components are both zero.
double without_rounding(double component) {
  constexpr double kRounding = 1e-9;
  return std::abs(component) < kRounding ? 0.0 : component;
}

/// The three numbers that the released loader calls the angles of a viewing direction.
std::array<double, 3> replay_angles(const Quaternion& orientation) {
  const Vector3 front = rotate(orientation, {1, 0, 0});
  const double x = without_rounding(front.x);
  const double y = without_rounding(front.y);
  const double z = without_rounding(front.z);
  return {std::atan2(y, x), std::atan2(z, y), std::atan2(z, x)};
}

EncodedPose encode_replay(const Pose& source_from_target, const Pose& world_from_source) {
  const Pose world_from_target = world_from_source * source_from_target;
  const Vector3 offset = world_from_target.position_m - world_from_source.position_m;
  const auto source_rad = replay_angles(world_from_source.orientation);
  const auto target_rad = replay_angles(world_from_target.orientation);
  const double distance = kCentimetresPerMetre * std::hypot(offset.x, offset.y);
  const double turned_rad = 90.0 - (source_rad[0] - std::atan2(offset.y, offset.x));
  EncodedPose encoded;
  encoded.tgt_pose = to_floats({distance * std::cos(turned_rad), distance * std::sin(turned_rad),
                                kCentimetresPerMetre * offset.z});
  for (std::size_t i = 0; i < source_rad.size(); ++i) {
    append_sine_cosine(encoded.tgt_rotation, target_rad[i] - source_rad[i]);
  }
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

/// First and last row, first and last column, as the released loader divides them. A box ends where
/// its last pixel does; one without extent stands for a speaker out of sight.
std::vector<float> encode_soundspaces_box(const Box& box) {
  constexpr double kPixels = 256.0;
  constexpr double kLoaderDivisor = 255.0;
  const auto first = [](double edge) { return kPixels * edge / kLoaderDivisor; };
  const auto last = [](double low, double high) {
    return std::max(kPixels * high - 1.0, kPixels * low) / kLoaderDivisor;
  };
  return to_floats(
      {first(box.y_min), last(box.y_min, box.y_max), first(box.x_min), last(box.x_min, box.x_max)});
}

}  // namespace

EncodedPose encode_pose(PoseEncoding encoding, const Pose& source_from_target,
                        const Pose& world_from_source) {
  switch (encoding) {
    case PoseEncoding::soundspaces:
      return encode_soundspaces(source_from_target);
    case PoseEncoding::replay:
      return encode_replay(source_from_target, world_from_source);
    case PoseEncoding::full:
      return encode_full(source_from_target);
  }
  EARPOINT_CHECK(false);
}

std::vector<float> encode_box(BoxEncoding encoding, const Box& box) {
  switch (encoding) {
    case BoxEncoding::soundspaces:
      return encode_soundspaces_box(box);
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

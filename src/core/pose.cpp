#include <earpoint/pose.h>

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>

namespace earpoint {
namespace {

double dot(const Quaternion& a, const Quaternion& b) {
  return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
}

Quaternion weighted_sum(const Quaternion& a, double wa, const Quaternion& b, double wb) {
  return {a.w * wa + b.w * wb, a.x * wa + b.x * wb, a.y * wa + b.y * wb, a.z * wa + b.z * wb};
}

}  // namespace

Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {
      a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
      a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

Quaternion conjugate(const Quaternion& q) { return {q.w, -q.x, -q.y, -q.z}; }

Vector3 rotate(const Quaternion& q, const Vector3& v) {
  const Vector3 axis{q.x, q.y, q.z};
  const Vector3 twice = 2.0 * cross(axis, v);
  return v + q.w * twice + cross(axis, twice);
}

Quaternion normalized(const Quaternion& q) {
  const double length = std::sqrt(dot(q, q));
  EARPOINT_CHECK(length > 0.0);
  return {q.w / length, q.x / length, q.y / length, q.z / length};
}

Quaternion slerp(const Quaternion& a, const Quaternion& b, double fraction) {
  double cosine = dot(a, b);
  const double sign =
      cosine < 0.0 ? -1.0 : 1.0;  // q and -q are the same turn: take the shorter arc
  cosine = std::min(1.0, std::abs(cosine));
  const double angle = std::acos(cosine);
  // Below this angle the weights' quotient loses digits, and the chord equals the arc.
  if (angle < 1e-6) return normalized(weighted_sum(a, 1.0 - fraction, b, sign * fraction));
  const double sine = std::sin(angle);
  return normalized(weighted_sum(a, std::sin((1.0 - fraction) * angle) / sine, b,
                                 sign * std::sin(fraction * angle) / sine));
}

Quaternion quaternion_from_euler(const EulerAngles& angles) {
  const Quaternion yaw{std::cos(angles.yaw_rad / 2), 0, 0, std::sin(angles.yaw_rad / 2)};
  // A right-handed turn about y lowers the front; pitch counts upwards.
  const Quaternion pitch{std::cos(angles.pitch_rad / 2), 0, -std::sin(angles.pitch_rad / 2), 0};
  const Quaternion roll{std::cos(angles.roll_rad / 2), std::sin(angles.roll_rad / 2), 0, 0};
  return yaw * pitch * roll;
}

EulerAngles euler_from_quaternion(const Quaternion& q) {
  const Vector3 front = rotate(q, {1, 0, 0});
  const Vector3 left = rotate(q, {0, 1, 0});
  const Vector3 up = rotate(q, {0, 0, 1});
  EulerAngles angles;
  angles.pitch_rad = std::asin(std::clamp(front.z, -1.0, 1.0));
  if (std::hypot(front.x, front.y) > 1e-9) {
    angles.yaw_rad = std::atan2(front.y, front.x);
    angles.roll_rad = std::atan2(left.z, up.z);
  } else {
    // Looking straight up or down: yaw and roll turn about the same axis; give it all to yaw.
    angles.yaw_rad = std::atan2(-left.x, left.y);
  }
  return angles;
}

Spherical spherical_from_cartesian(const Vector3& v) {
  const double horizontal = std::hypot(v.x, v.y);
  return {std::atan2(v.y, v.x), std::atan2(v.z, horizontal), norm(v)};
}

Vector3 cartesian_from_spherical(const Spherical& s) {
  const double horizontal = s.distance_m * std::cos(s.elevation_rad);
  return {horizontal * std::cos(s.azimuth_rad), horizontal * std::sin(s.azimuth_rad),
          s.distance_m * std::sin(s.elevation_rad)};
}

Pose operator*(const Pose& a, const Pose& b) {
  return {a.position_m + rotate(a.orientation, b.position_m), a.orientation * b.orientation};
}

Pose inverse(const Pose& pose) {
  const Quaternion turn = conjugate(pose.orientation);
  return {-rotate(turn, pose.position_m), turn};
}

Vector3 transform_point(const Pose& pose, const Vector3& point) {
  return pose.position_m + rotate(pose.orientation, point);
}

Pose interpolate(const Pose& a, const Pose& b, double fraction) {
  return {a.position_m * (1.0 - fraction) + b.position_m * fraction,
          slerp(a.orientation, b.orientation, fraction)};
}

Pose look_at(const Vector3& position_m, const Vector3& target_m) {
  const Vector3 offset = target_m - position_m;
  EARPOINT_CHECK(norm(offset) > 0.0);
  const Spherical direction = spherical_from_cartesian(offset);
  return {position_m, quaternion_from_euler({.yaw_rad = direction.azimuth_rad,
                                             .pitch_rad = direction.elevation_rad})};
}

double wrap_angle(double radians) {
  const double wrapped = std::remainder(radians, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

}  // namespace earpoint

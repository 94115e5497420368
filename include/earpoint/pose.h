#pragma once

#include <earpoint/vector3.h>

namespace earpoint {

/// The project's one frame, as in SOFA and REP-103: x front, y left, z up, right-handed, metres.
/// Angles are radians here; degrees appear only in files and on the command line.

/// A rotation as a unit quaternion, w + xi + yj + zk.
struct Quaternion {
  double w = 1.0;
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  friend constexpr bool operator==(const Quaternion&, const Quaternion&) = default;
};

/// @return a rotated after b: (a * b) applied to v is a applied to (b applied to v).
Quaternion operator*(const Quaternion& a, const Quaternion& b);
Quaternion conjugate(const Quaternion& q);
Vector3 rotate(const Quaternion& q, const Vector3& v);

/// @throws std::logic_error if q is zero
Quaternion normalized(const Quaternion& q);

/// Spherical interpolation along the shorter arc.
/// @param fraction  0 gives a, 1 gives b
Quaternion slerp(const Quaternion& a, const Quaternion& b, double fraction);

/// A head's turn, applied in the order roll, pitch, yaw.
struct EulerAngles {
  double yaw_rad = 0.0;    ///< about z; positive turns to the left
  double pitch_rad = 0.0;  ///< positive looks up, like SOFA's elevation (REP-103's sign, negated)
  double roll_rad = 0.0;   ///< about x; positive lowers the right ear
};

Quaternion quaternion_from_euler(const EulerAngles& angles);

/// @return yaw and roll in (-pi, pi], pitch in [-pi/2, pi/2]
EulerAngles euler_from_quaternion(const Quaternion& q);

/// A direction as seen from the origin.
struct Spherical {
  double azimuth_rad = 0.0;    ///< counter-clockwise from front: left is +pi/2
  double elevation_rad = 0.0;  ///< up is +pi/2
  double distance_m = 0.0;
};

/// @return azimuth in (-pi, pi]; all zero for the origin
Spherical spherical_from_cartesian(const Vector3& v);
Vector3 cartesian_from_spherical(const Spherical& s);

/// A rigid transform. Named after what it maps: `world_from_listener` takes a point in the
/// listener's frame to the world's; its position is where the listener stands in the world.
struct Pose {
  Vector3 position_m;
  Quaternion orientation;

  friend constexpr bool operator==(const Pose&, const Pose&) = default;
};

/// @return a_from_c, given a = a_from_b and b = b_from_c
Pose operator*(const Pose& a, const Pose& b);
Pose inverse(const Pose& pose);

/// Maps a point (position and orientation apply).
Vector3 transform_point(const Pose& pose, const Vector3& point);

/// Position linear, orientation by slerp.
Pose interpolate(const Pose& a, const Pose& b, double fraction);

/// A pose at `position_m` whose front points at `target_m`, level: its left lies in the x-y plane.
/// @throws std::logic_error if the two coincide
Pose look_at(const Vector3& position_m, const Vector3& target_m);

constexpr double kPi = 3.14159265358979323846;
constexpr double radians_from_degrees(double degrees) { return degrees * (kPi / 180.0); }
constexpr double degrees_from_radians(double radians) { return radians * (180.0 / kPi); }

/// @return the same angle in (-pi, pi]
double wrap_angle(double radians);

}  // namespace earpoint

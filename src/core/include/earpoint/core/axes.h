#pragma once

#include <earpoint/pose.h>

namespace earpoint {

/// The orientation whose own x, y and z axes point there: the rotation matrix with these columns.
/// @param x, y, z  unit length, at right angles, right-handed; within rounding
/// Source: Shepperd, Journal of Guidance and Control 1 (1978).
[[nodiscard]] Quaternion quaternion_from_axes(const Vector3& x, const Vector3& y, const Vector3& z);

}  // namespace earpoint

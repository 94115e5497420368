#pragma once

#include <earpoint/core/json_field.h>
#include <earpoint/pose.h>
#include <earpoint/record/session.h>

namespace earpoint {

/// The frame that a session's positions and extrinsics are written in.
struct CalibrationFrame {
  double metres_per_unit = 1.0;
  bool opencv = false;  ///< extrinsics map the world to a camera with x right, y down, z forward
  Quaternion ours_from_theirs{};  ///< turns their axis that points up to z
};

/// From the fields "units", "frame" and "up" of a session. @throws InputError naming the field
[[nodiscard]] CalibrationFrame calibration_frame(const JsonField& session);

[[nodiscard]] Vector3 position_of(const JsonField& field, const CalibrationFrame& frame);

/// @throws InputError naming the field
[[nodiscard]] Lens lens_of(const JsonField& intrinsics);
[[nodiscard]] Pose pose_of(const JsonField& extrinsics, const CalibrationFrame& frame);

/// Fills in what a calibration file tells of cameras that have no lens or pose of their own: the
/// field "calibration" of a session. Cameras that it does not name stay as they are.
/// @throws InputError naming the field, or the file and line
void apply_calibration(const JsonField& calibration, const CalibrationFrame& frame,
                       Session& session);

}  // namespace earpoint

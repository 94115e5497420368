#pragma once

#include <optional>
#include <vector>

#include <earpoint/core/image.h>
#include <earpoint/core/pose.h>
#include <earpoint/model/network.h>

namespace earpoint {

/// What a network is told about the target: two vectors whose meaning its description names.
struct EncodedPose {
  std::vector<float> tgt_pose;
  std::vector<float> tgt_rotation;
};

/// Writes a relative pose the way a network was trained on.
///
/// - soundspaces: [d, sin a, cos a] and [sin r, cos r]: d is the horizontal distance in metres, a
/// the
///   target's azimuth and r its turn, both counter-clockwise. Height, pitch and roll are lost, as
///   in the released network.
/// - replay: as the released loader writes it for a source view that looks along the world's x
/// axis:
///   [d cos q, d sin q, z] in centimetres with q = 90 rad + a (the loader takes 90 as radians, and
///   the network was trained with that), and sine and cosine of the change of the three angles
///   atan2(y, x), atan2(z, y), atan2(z, x) of the viewing direction.
/// - full: [x, y, z] in metres, and sine and cosine of yaw, pitch and roll.
EncodedPose encode_pose(PoseEncoding encoding, const Pose& source_from_target);

/// @return the four numbers of `bboxes`: [y_min, y_max, x_min, x_max] for soundspaces, [x_min,
///         y_min, x_max, y_max] for corners, fractions of the picture; for centre [1, 4 (x - 1/2),
///         4 (y - 1/2), 2 ln 2 h] of its middle and height, zeros for a box without height
std::vector<float> encode_box(BoxEncoding encoding, const Box& box);

/// The same; four zeros stand for a speaker who is out of sight, as in the SoundSpaces data set.
std::vector<float> encode_box(BoxEncoding encoding, const std::optional<Box>& box);

}  // namespace earpoint

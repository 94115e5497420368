#pragma once

#include <optional>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/pose.h>

namespace earpoint {

/// What the numbers in `tgt_pose` and `tgt_rotation` mean. docs/formats.md has the formulas.
enum class PoseEncoding {
  soundspaces,  ///< [distance, sin, cos of the bearing] and [sin, cos of the turn]: 3 + 2
  replay,  ///< [x, y, z] in centimetres, turned as in the released code, and 3 x [sin, cos]: 3 + 6
  full,    ///< [x, y, z] in metres, our frame, and [sin, cos] of yaw, pitch, roll: 3 + 6
};

/// What the four numbers in `bboxes` mean.
enum class BoxEncoding {
  soundspaces,  ///< [y_min, y_max, x_min, x_max], pixels of 256 divided by 255
  corners,      ///< [x_min, y_min, x_max, y_max], from 0 to 1
  centre,       ///< [1, 4 (x - 1/2), 4 (y - 1/2), 2 ln 2 h]: middle and height, of like spread
};

/// A network's inputs for the target pose: two vectors, defined by its description.
struct EncodedPose {
  std::vector<float> tgt_pose;
  std::vector<float> tgt_rotation;
};

/// Writes the target's pose the way a network was trained on.
///
/// - soundspaces: [d, sin a, cos a] and [sin r, cos r]: d is the horizontal distance in metres, a
///   the target's azimuth and r its turn, both counter-clockwise. Height, pitch and roll are lost,
///   as in the released network.
/// - replay: as the released loader writes it: [d cos q, d sin q, z2 - z1] in centimetres, where
///   q = 90 rad - (e - phi), e is the source's heading and phi the bearing of the target, both in
///   the world's axes (the loader takes 90 as radians, and the network was trained with that); then
///   sine and cosine of the differences of atan2(y, x), atan2(z, y), atan2(z, x) of the two viewing
///   directions. Those differences depend on the world's axes, so that the relative pose is not
///   enough.
/// - full: [x, y, z] in metres, and sine and cosine of yaw, pitch and roll.
///
/// @param world_from_source  z up; of the Replay recordings, their own x and y axes. Only replay
///                           uses it. The identity stands for a source that looks along x
EncodedPose encode_pose(PoseEncoding encoding, const Pose& source_from_target,
                        const Pose& world_from_source = {});

/// @return the four numbers of `bboxes`: for soundspaces [y_min, y_max, x_min, x_max], the first
///         and the last row and column of a picture of 256 pixels, divided by 255 as the released
///         loader does; for corners [x_min, y_min, x_max, y_max], fractions of the picture; for
///         centre [1, 4 (x - 1/2), 4 (y - 1/2), 2 ln 2 h] of its middle and height, zeros for a box
///         without height
std::vector<float> encode_box(BoxEncoding encoding, const Box& box);

/// The same; four zeros stand for a speaker who is out of sight, as in the SoundSpaces data set.
std::vector<float> encode_box(BoxEncoding encoding, const std::optional<Box>& box);

}  // namespace earpoint

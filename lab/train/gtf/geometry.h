#pragma once

#include <ATen/core/Tensor.h>

namespace earpoint {

/// Tables of a head; see GtfDescription.
struct HeadTables {
  at::Tensor power;          ///< [azimuths][2][bands]
  at::Tensor diffuse_power;  ///< [2][bands]
  at::Tensor delay_s;        ///< [azimuths][2]
};

/// Where a speaker is, clips along the first axis, in the source's frame.
struct SpeakerPlace {
  at::Tensor position_m;       ///< [clips][3]
  at::Tensor heading;          ///< [clips][2], of any length
  at::Tensor log_reverberant;  ///< [clips]: log of the reverberant power over the direct at 1 m
};

/// What the move from source to target does, by geometry.
struct MoveGeometry {
  at::Tensor features;  ///< [clips][52]
  /// [clips][2][bands]: log of the expected amplitude at the target's ears over the source's
  at::Tensor expected_log_gain;
  at::Tensor source_delay_s;  ///< [clips][2]: of the direct sound at the ears
  at::Tensor target_delay_s;
};

/// The bare pose of the target: position in units of 3 m, sine and cosine of its yaw.
/// @param position_m  [clips][3] @param yaw_rad  [clips][1]
/// @return [clips][5]
at::Tensor pose_features(const at::Tensor& position_m, const at::Tensor& yaw_rad);

/// Directions, distances, levels and delays of the speaker at source and target.
/// @param target_m [clips][3] @param target_yaw_rad [clips][1]: the target in the source's frame
MoveGeometry move_geometry(const HeadTables& head, const SpeakerPlace& speaker,
                           const at::Tensor& target_m, const at::Tensor& target_yaw_rad);

}  // namespace earpoint

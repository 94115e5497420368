#pragma once

#include <earpoint/core/pose.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset/replay.h>

namespace earpoint {

/// Where a camera stands in the recorded room, in metres; z is up and the axes are the recording's.
[[nodiscard]] Pose world_from_camera(const ReplayCamera& camera);

/// A sample of Replay-NVAS in the form that methods and networks take. Recordings do not tell
/// the dry speech: PairSample::dry is empty. Where the speaker stands is known of clips with
/// ReplayClip::mouth_m alone; else speaker_m is the origin.
/// @param align  as ReplayDataset::sample()
/// @throws InputError as ReplayDataset::sample()
[[nodiscard]] PairSample replay_pair(const ReplayDataset& dataset, const ReplayClip& clip,
                                     const ReplayChoice& choice, bool align);

}  // namespace earpoint

#pragma once

#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/pose.h>

namespace earpoint {

/// Where a camera stands in the recorded room, in metres; z is up and the axes are the recording's.
[[nodiscard]] Pose world_from_camera(const ReplayCamera& camera);

/// A sample of Replay-NVAS in the form that methods and networks take. PairSample::dry is empty;
/// see near_voice(). Where the speaker stands is known of clips with ReplayClip::mouth_m alone;
/// else speaker_m is the origin.
/// @param align  as ReplayDataset::sample()
/// @throws InputError as ReplayDataset::sample()
[[nodiscard]] PairSample replay_pair(const ReplayDataset& dataset, const ReplayClip& clip,
                                     const ReplayChoice& choice, bool align);

/// The near microphone's sound in the place of dry speech, which recordings do not tell: moved such
/// that the source hears it at once, by GCC-PHAT, and as loud as the source, for nothing is known
/// of the microphone's gain.
/// @param source  of a sample of that clip, aligned or not
/// @return        1 channel, as long as the source; silence where either is silent
/// @throws InputError if the clip has no near.wav, or it is malformed
[[nodiscard]] Waveform near_voice(const ReplayDataset& dataset, const ReplayClip& clip,
                                  const Waveform& source);

}  // namespace earpoint

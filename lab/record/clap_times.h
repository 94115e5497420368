#pragma once

#include <array>
#include <optional>

#include <earpoint/pose.h>
#include <earpoint/vector3.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// When both ears of a camera hear the clap directly, to some hundredths of a millisecond: the time
/// at which sound rises steeply, at each ear, such that the ears are as far apart as the clapper's
/// direction has them. A reflection, or a voice before the clap, hardly ever is at both.
/// @param sound         2 channels, else a caller's bug; on the camera's clock
/// @param about_s       within some 20 ms of the clap
/// @param interaural_s  arrival at the left ear minus that at the right, seconds; negative: left
///                      first
/// @return  seconds on the camera's clock, {left, right}; nothing where no pair fits
[[nodiscard]] std::optional<std::array<double, 2>> clap_at_ears(const Waveform& sound,
                                                                double about_s,
                                                                double interaural_s);

/// When a clapper of known place clapped, by the direct sound at both ears of a camera.
/// @param sound            2 channels, else a caller's bug; on the camera's clock
/// @param about_s          within some 20 ms of when the camera heard it
/// @param clap_m           in the world
/// @return  seconds on the camera's clock, the way from the clapper taken off; nothing where the
///          direct sound is not at both ears
[[nodiscard]] std::optional<double> clap_emitted_s(const Waveform& sound, double about_s,
                                                   const Vector3& clap_m,
                                                   const Pose& world_from_head);

}  // namespace earpoint

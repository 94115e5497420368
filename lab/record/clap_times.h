#pragma once

#include <array>
#include <optional>

#include <earpoint/core/waveform.h>

namespace earpoint {

/// When both ears of a camera hear the clap directly, to some hundredths of a millisecond: the time
/// at which sound rises steeply, at each ear, such that the ears are as far apart as the clapper's
/// direction has them. A reflection, or a voice before the clap, hardly ever is at both.
/// @param sound         of 2 ears, on the camera's clock
/// @param about_s       within some 20 ms of the clap
/// @param interaural_s  how much later the left ear must hear it
/// @return  by ear; nothing where none fits
[[nodiscard]] std::optional<std::array<double, 2>> clap_at_ears(const Waveform& sound,
                                                                double about_s,
                                                                double interaural_s);

}  // namespace earpoint

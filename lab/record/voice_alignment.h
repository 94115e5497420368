#pragma once

#include "clock_fit.h"

#include <vector>

namespace earpoint {

/// Clocks and places to begin fit_clocks() with.
struct VoiceAlignment {
  std::vector<DeviceClock> clocks;
  std::vector<Vector3> places;  ///< of each event's source, at the height of the centre
};

/// Finds clocks to about a millisecond and places to some decimetres, without places to begin with.
///
/// First every pair of a device that tells the moment and a camera gets the offset and the drift
/// that most times of arrival support, as if all sounds came from the centre. Then places are
/// searched on a grid around the cameras: by the times at the ears, which need the clocks, and by
/// the interaural time differences, which do not. Clocks and places are found again in turns, each
/// time by a narrower tolerance. Reflections are outvoted: their lateness changes with the place.
/// @param devices    the first is the reference; all cameras calibrated
/// @param centre_m   about where people are
/// @param error_s    by how much clocks may be wrong; rounds for larger errors are left out
/// Cost: O(events x grid x ears); a second or two for 600 events and 8 cameras.
[[nodiscard]] VoiceAlignment align_voices(const std::vector<FitDevice>& devices,
                                          const std::vector<SoundEvent>& events,
                                          const Vector3& centre_m, double error_s);

}  // namespace earpoint

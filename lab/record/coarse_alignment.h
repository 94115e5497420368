#pragma once

#include <optional>
#include <span>
#include <vector>

#include <earpoint/record/session_truth.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// How suddenly sound sets in, every kOnsetHop_s: the rise in dB of the pre-emphasised power, 0
/// where it falls, less its mean.
inline constexpr double kOnsetHop_s = 0.002;
[[nodiscard]] std::vector<float> onset_strength(const Waveform& sound);

/// A clock to about ten milliseconds, from onsets alone: travel times are not known yet.
struct CoarseClock {
  DeviceClock clock;          ///< against the reference's clock, without a name
  double significance = 0.0;  ///< of the match: the correlation's peak in standard deviations
};

/// Matches the onsets of a device with those of the reference: over all lags for the offset, then
/// by blocks of 20 s for the drift.
/// @param device, reference  from onset_strength()
[[nodiscard]] CoarseClock coarse_clock(std::span<const float> device,
                                       std::span<const float> reference);

/// A match below this is none: noise against noise over ten minutes reaches about 5.
inline constexpr double kLeastSignificance = 6.5;

/// A clap: the steepest rise of sound within a stretch of time.
struct Clap {
  double time_s = 0.0;   ///< when it begins, on the device's clock
  double rise_db = 0.0;  ///< over the loudest of the 30 ms before
};
/// @return nothing if the sound has no samples there
[[nodiscard]] std::optional<Clap> find_clap(const Waveform& sound, double from_s, double to_s);

}  // namespace earpoint

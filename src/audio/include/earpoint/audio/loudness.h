#pragma once

#include <optional>

#include <earpoint/waveform.h>

namespace earpoint {

/// Integrated loudness: K-weighted, blocks of 400 ms that overlap by 75 %, gated at -70 LKFS and at
/// 10 LU below the mean of what is left. All channels have weight 1. Sound that is shorter than a
/// block is one block.
///
/// @param sound  1 channel or more, > 0 samples, any rate (it is weighted at 48 kHz)
/// @return  LKFS: -3.01 for a sine of 997 Hz at full scale in one channel; nothing where no block
///          is above -70 LKFS
/// Source: ITU-R BS.1770-4, annex 1.
[[nodiscard]] std::optional<double> loudness_lkfs(const Waveform& sound);

}  // namespace earpoint

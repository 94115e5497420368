#pragma once

#include <cstddef>

#include <earpoint/waveform.h>

namespace earpoint {

/// A part of a sound. Zeros where the sound has ended.
/// @param start    its first sample, >= 0
/// @param samples  its length, >= 0
/// @return  [channels][samples], at the sound's rate
[[nodiscard]] Waveform window_of(const Waveform& sound, std::ptrdiff_t start,
                                 std::ptrdiff_t samples);

}  // namespace earpoint

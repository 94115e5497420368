#pragma once

#include <cstddef>
#include <cstdint>

#include <earpoint/audio/ambient_separation.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Below it a sound counts as ambient: the high-pass of the paper's ambient separation, Hz.
inline constexpr double kSeparationCutoffHz = 80.0;

/// Below it the spectrum of a quiet room's noise is flat.
inline constexpr double kRoomNoiseCornerHz = 20.0;

/// Adds the steady noise of a quiet room: the same spectrum everywhere, flat below the corner and
/// falling by 6 dB an octave above, independent in every channel.
/// @param level_db  root mean square of the noise, re full scale
/// @param random    what it is drawn from: the same state gives the same noise
/// @param context   samples before the window: the window's noise is drawn first, so that it is the
///                  same with and without
/// @param corner_hz  at half the sample rate the noise is nearly white
void add_room_noise(Waveform& sound, double level_db, RandomStream& random,
                    std::ptrdiff_t context = 0, double corner_hz = kRoomNoiseCornerHz);

/// Adds such noise to what both viewpoints of a sample hear, the source first.
void add_ambient(PairSample& sample, double level_db, std::uint64_t seed);

/// The primary sound of a recording in memory, without what is below kSeparationCutoffHz.
/// @return [channels][samples]
[[nodiscard]] Waveform primary_sound(const Waveform& sound, AmbientSeparation separation);

/// Takes ambient sound out of what the source hears and keeps it as PairSample::ambient. The target
/// is left as it is.
void separate_source(PairSample& sample,
                     AmbientSeparation separation = AmbientSeparation::bandpass);

}  // namespace earpoint

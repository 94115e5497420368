#pragma once

#include <filesystem>

namespace earpoint {

/// Test support: a data set in the form of RWAVS with two scenes, "1" and "2", of 8.4 s at
/// 22,050 Hz. In each the loudspeaker stands at (0.1, 0.2, 0.3) and plays pulses of noise; poses of
/// the seconds 1 to 8 lie on a circle of 0.4 around it (scene 2: 0.2) and look along x or -x.
/// Seconds 4 and 8 are val, the others train. The ear on the loudspeaker's side hears it 6 dB
/// louder than the other. Scene 2 is half as loud.
/// @param folder  gets position.json and the scenes
void write_tiny_rwavs(const std::filesystem::path& folder);

/// Test support: a room in the form of Real Acoustic Fields: data/000000 to data/000007 and
/// metadata. In our frame item i has its microphone i / 2 m to the left of the origin, 1.5 m high,
/// and the loudspeaker 2 m in front of it, 1 m high, facing it. Responses are noise at 48 kHz,
/// 0.4 s long, that falls by 60 dB in 0.3 + 0.02 i seconds. Items 0, 2, 4, 6 are train, 1 and 3
/// validation, 5 and 7 test.
/// @param folder  of the room
void write_tiny_raf(const std::filesystem::path& folder);

}  // namespace earpoint

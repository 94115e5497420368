#pragma once

#include <array>
#include <vector>

#include <earpoint/pose.h>
#include <earpoint/spatial/air_absorption.h>
#include <earpoint/spatial/arrival.h>

namespace earpoint {

/// An empty rectangular room with a corner at the world's origin.
struct Shoebox {
  Vector3 lengths_m{};  ///< along x, y, z; > 0
  /// Absorbed share of energy, per wall and band, in [0, 1]. Walls: x low, x high, y low, y high,
  /// z low (floor), z high (ceiling).
  std::array<BandArray, 6> absorption{};
  Air air{};
};

/// Every specular path of an omnidirectional source, exactly: the image-source method. A wall's
/// pressure reflection is sqrt(1 - absorption), real and independent of the angle; the air's
/// absorption and 1/distance apply to the whole way. There is no scattering.
///
/// @param source_m             in the room
/// @param world_from_listener  in the room
/// @param max_time_s           later arrivals are left out
/// @param max_order            paths with more reflections are left out; negative: no such limit
/// @return  sorted by delay
/// @throws InputError if the room has no size, an absorption is outside [0, 1], source or
///         listener is not inside, the two are closer than 1 mm, or more than 20 million arrivals
///         would come
/// Source: Allen and Berkley, JASA 65 (1979).
[[nodiscard]] std::vector<Arrival> shoebox_arrivals(const Shoebox& room, const Vector3& source_m,
                                                    const Pose& world_from_listener,
                                                    double max_time_s, int max_order = -1);

/// Reverberation time by Eyring's formula with air absorption, per band, in seconds: the decay
/// that a diffuse sound field in this room would have. A truly specular box decays more slowly.
/// Source: Eyring, JASA 1 (1930); 4 m V of the air as in ISO 354.
[[nodiscard]] BandArray eyring_reverberation_time_s(const Shoebox& room);

}  // namespace earpoint

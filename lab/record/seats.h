#pragma once

#include "clock_fit.h"

#include <cstddef>
#include <vector>

#include <earpoint/vector3.h>

namespace earpoint {

/// Places of events, some of which are shared.
struct SharedPlaces {
  std::vector<Vector3> places_m;     ///< [events]
  std::vector<std::size_t> seat_of;  ///< [events]; events of one seat have one place
  std::size_t seats = 0;
};

/// Lets events of a voice that stays where it is share one place: else all places together move a
/// little in the course of the session, and clocks with them.
/// @param places_m  [events]
/// @param reach_m   a voice within so far of where it was, horizontally, stayed there
[[nodiscard]] SharedPlaces share_places(const std::vector<SoundEvent>& events,
                                        std::vector<Vector3> places_m, double reach_m);

/// Moves places to the median of the same voice's within two seconds where they are far from it: a
/// few ears that agree by chance hold them there.
/// @param places_m  [events]
/// @param height_m  of a place that is moved
[[nodiscard]] std::vector<Vector3> gathered_places(const std::vector<SoundEvent>& events,
                                                   const std::vector<Vector3>& places_m,
                                                   double height_m);

}  // namespace earpoint

#pragma once

#include <earpoint/core/octave_bands.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// One wave front that reaches the listener.
struct Arrival {
  double delay_s = 0.0;  ///< since the source emitted it
  Vector3 direction;     ///< unit vector to where it comes from, in the listener's frame
  Vector3 departure;     ///< unit vector along which it left the source, in the world's frame
  BandArray gain{};      ///< pressure per band, 1 for the direct sound at 1 m; may be negative
  int order = 0;         ///< reflections on the way
};

}  // namespace earpoint

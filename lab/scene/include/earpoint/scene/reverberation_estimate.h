#pragma once

#include <array>
#include <vector>

#include <earpoint/core/octave_bands.h>
#include <earpoint/scene/homes.h>

namespace earpoint {

/// How long a room would reverberate if its sound were diffuse: a first guess, before tracing.
struct ReverberationEstimate {
  double volume_m3 = 0.0;
  double surface_m2 = 0.0;  ///< of all faces, furniture included
  BandArray absorption{};   ///< mean over the surface
  std::array<double, kOctaveBands> sabine_s{};
  std::array<double, kOctaveBands> eyring_s{};
};

/// Estimates every room of a home on its own. Faces belong to the room that their middle lies in,
/// those in doorways and recesses to the nearest; doors count as walls, air absorbs nothing.
///
/// Source: Sabine 0.161 V / A; Eyring, JASA 1 (1930), 0.161 V / (-S ln(1 - mean absorption)).
std::vector<ReverberationEstimate> estimate_reverberation(const Home& home);

}  // namespace earpoint

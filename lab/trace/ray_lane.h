#pragma once

#include "mirror_chain.h"
#include "scene_geometry.h"

#include <array>
#include <cmath>

#include <earpoint/core/octave_bands.h>
#include <earpoint/core/random.h>

namespace earpoint {

using Float3 = std::array<float, 3>;

inline float dot(const Float3& a, const Float3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline float sum(const BandArray& bands) {
  float total = 0.0F;
  for (const float band : bands) total += band;
  return total;
}

/// What has happened to a ray so far: decides who counts its energy at a listener.
enum class Leg {
  direct,    ///< straight from the source: an arrival
  mirrored,  ///< off mirrors only: an arrival, within the limits of `MirrorLimits`
  specular,  ///< off a mirror last: counted at the sphere
  diffuse,   ///< off a diffuse reflection last: already sent to the listeners
};

/// A ray on its walk.
struct Lane {
  bool alive = false;
  Leg leg = Leg::direct;
  int bounces = 0;
  MirrorChain chain;
  float travelled_m = 0.0F;  ///< to `origin`
  float turned_m = 0.0F;     ///< to the last diffuse reflection, or 0
  float first_energy = 0.0F;
  Float3 origin{};
  Float3 direction{};
  LayerMask mask = kAllLayers;
  const BounceFacet* entered = nullptr;  ///< the face through which it came into a wall
  bool passing = false;                  ///< it has just met that wall's other side
  BandArray energy{};
  RandomStream random{0};
};

/// A point drawn evenly from the unit sphere's surface (Marsaglia, 1972).
inline Float3 random_direction(RandomStream& random) {
  for (;;) {
    const auto x = static_cast<float>(random.uniform(-1.0, 1.0));
    const auto y = static_cast<float>(random.uniform(-1.0, 1.0));
    const float squared = x * x + y * y;
    if (squared >= 1.0F) continue;
    const float scale = 2.0F * std::sqrt(1.0F - squared);
    return {x * scale, y * scale, 1.0F - 2.0F * squared};
  }
}

/// Lambert's law about a normal: a point of the unit sphere that touches the surface from above.
inline Float3 diffuse_direction(const Float3& normal, RandomStream& random) {
  const Float3 point = random_direction(random);
  Float3 direction = {normal[0] + point[0], normal[1] + point[1], normal[2] + point[2]};
  const float length = std::sqrt(dot(direction, direction));
  if (length < 1e-4F) return normal;
  for (float& component : direction) component /= length;
  return direction;
}

/// Multiplies the energy of every band by its share and by `scale`.
inline void weigh(Lane& lane, const BandArray& shares, float scale) {
  for (int band = 0; band < kOctaveBands; ++band) lane.energy[band] *= shares[band] * scale;
}

}  // namespace earpoint

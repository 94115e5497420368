#pragma once

#include "scene_geometry.h"

#include <algorithm>

namespace earpoint {

/// Which sound is left to image sources (`specular_paths.h`): what has met nothing but mirrors,
/// within these limits. The rest is left to the random walk (`ray_walk.h`). Both ask `MirrorChain`
/// about what a ray has met, so that no energy is lost or counted twice.
struct MirrorLimits {
  int max_reflections = 0;      ///< 0: image sources hold nothing but the direct sound
  double max_distance_m = 0.0;  ///< of the image source from the listener
  double min_energy = 0.0;  ///< what is left, in the loudest band, after absorption and scattering
  double min_purity = 0.0;  ///< what is left of the same after scattering alone
};

/// What a ray has met since it left the source.
class MirrorChain {
 public:
  /// @return whether sound that has come this way and meets a mirroring facet next is still left to
  ///         image sources
  bool reflect(const BounceFacet& facet, const BounceSurface& surface, const MirrorLimits& limits) {
    ++reflections_;
    energy_ *= surface.most_specular;
    purity_ *= surface.purity;
    held_ = held_ && facet.mirror && reflections_ <= limits.max_reflections &&
            energy_ >= limits.min_energy && purity_ >= limits.min_purity;
    return held_;
  }

  /// It was reflected diffusely, or went through a wall: image sources do not follow.
  void leave() { held_ = false; }

  [[nodiscard]] bool held() const { return held_; }
  [[nodiscard]] int reflections() const { return reflections_; }

 private:
  int reflections_ = 0;
  double energy_ = 1.0;
  double purity_ = 1.0;
  bool held_ = true;
};

}  // namespace earpoint

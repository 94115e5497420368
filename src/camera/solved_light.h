#pragma once

#include "lit_scene.h"

#include <cstdint>
#include <vector>

namespace earpoint {

/// The light that surfaces send out, once it is solved for all patches: found at once for what a
/// ray meets.
class SolvedLight {
 public:
  /// @param irradiance  as solve_patch_light gives it
  SolvedLight(const LitScene& scene, const std::vector<Rgb>& irradiance);

  /// Keeps the light of `base` and adds that of the triangles that the scene has beyond it.
  /// @param first_patch  of those triangles
  /// @param irradiance   of the patches from `first_patch` on
  SolvedLight(const SolvedLight& base, const LitScene& scene, std::uint32_t first_patch,
              const std::vector<Rgb>& irradiance);

  /// How many triangles it knows.
  [[nodiscard]] std::uint32_t triangles() const {
    return static_cast<std::uint32_t>(records_.size());
  }

  /// The radiance that a surface sends back along a ray, without its own emission.
  /// @param aside  uniform; reads the place up to half a patch aside, which blurs the borders
  [[nodiscard]] Rgb radiance(const Hit& hit, const Float3& direction, UnitPair aside) const;

  /// Brings what radiance() will read of a triangle nearer: a hint for speed.
  void prefetch(std::uint32_t triangle) const { __builtin_prefetch(&records_[triangle]); }

  /// Whether the triangle shines.
  [[nodiscard]] bool shines(std::uint32_t triangle) const { return records_[triangle].shines; }

 private:
  // What has to be known of a triangle, within one line of the processor's cache.
  struct alignas(32) Record {
    Float3 normal;
    TriangleCut cut;
    bool shines = false;
  };

  void append(const LitScene& scene, std::uint32_t first_patch, const std::vector<Rgb>& irradiance);

  std::vector<Record> records_;  // [triangles]
  std::vector<Rgb> radiance_;    // [bins]
};

}  // namespace earpoint

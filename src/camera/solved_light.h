#pragma once

#include "patch_light.h"

#include <cstdint>
#include <vector>

namespace earpoint {

/// The light that surfaces send out, once it is solved for all patches: found at once for what a
/// ray meets.
class SolvedLight {
 public:
  /// @param irradiance  as solve_patch_light gives it
  SolvedLight(const LitScene& scene, const std::vector<Rgb>& irradiance);

  /// The radiance that a surface sends back along a ray, without its own emission.
  /// @param aside  uniform; reads the place up to half a patch aside, which blurs the borders
  [[nodiscard]] Rgb radiance(const Hit& hit, const Float3& direction, UnitPair aside) const;

  /// Whether the triangle shines.
  [[nodiscard]] bool shines(std::uint32_t triangle) const { return records_[triangle].shines; }

 private:
  // What has to be known of a triangle, within one line of the processor's cache.
  struct alignas(32) Record {
    Float3 normal;
    TriangleCut cut;
    bool shines = false;
  };

  std::vector<Record> records_;  // [triangles]
  std::vector<Rgb> radiance_;    // [bins]
};

}  // namespace earpoint

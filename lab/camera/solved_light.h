#pragma once

#include "lit_scene.h"

#include <cstddef>
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
  [[nodiscard]] Rgb radiance(const Hit& hit, const Float3& direction, UnitPair aside) const {
    return radiance_[bin_of(hit, direction, aside)];
  }

  /// The same in steps, each of which asks for the memory that the next one reads: a hint for the
  /// speed of many at once.
  void prefetch(std::uint32_t triangle) const { __builtin_prefetch(&records_[triangle]); }
  [[nodiscard]] std::size_t prefetch_bin(const Hit& hit, const Float3& direction,
                                         UnitPair aside) const {
    const std::size_t bin = bin_of(hit, direction, aside);
    __builtin_prefetch(&radiance_[bin]);
    return bin;
  }
  [[nodiscard]] const Rgb& radiance_of_bin(std::size_t bin) const { return radiance_[bin]; }

  /// Whether the triangle shines.
  [[nodiscard]] bool shines(std::uint32_t triangle) const { return records_[triangle].shines; }

 private:
  // What has to be known of a triangle, within one line of the processor's cache.
  struct alignas(32) Record {
    Float3 normal;
    TriangleCut cut;
    bool shines = false;
  };

  [[nodiscard]] std::size_t bin_of(const Hit& hit, const Float3& direction, UnitPair aside) const {
    const Record& record = records_[hit.triangle];
    const bool front = dot(record.normal, direction) <= 0.0F;
    const float u = hit.u + (aside.u - 0.5F) * record.cut.step;
    const float v = hit.v + (aside.v - 0.5F) * record.cut.step;
    return record.cut.bin(u, v, front);
  }

  void append(const LitScene& scene, std::uint32_t first_patch, const std::vector<Rgb>& irradiance);

  std::vector<Record> records_;  // [triangles]
  std::vector<Rgb> radiance_;    // [bins]
};

}  // namespace earpoint

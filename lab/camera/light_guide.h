#pragma once

#include "lights.h"
#include "patches.h"
#include "ray_tracer.h"

#include <cstdint>
#include <vector>

#include <earpoint/core/parallel.h>

namespace earpoint {

/// Which lights matter where: for each region of a scene, chances proportional to the light that
/// was found to arrive from each. A picture then spends its shadow rays on the lamp of this room,
/// not on those of the next.
class LightGuide {
 public:
  LightGuide(const Lights& lights, const Patches& patches, const Surfaces& surfaces,
             const RayTracer& tracer, ThreadPool& pool);

  /// Keeps what `base` found out and looks at the regions that `patches` has beyond it.
  LightGuide(const LightGuide& base, const Lights& lights, const Patches& patches,
             const Surfaces& surfaces, const RayTracer& tracer, ThreadPool& pool);

  struct Choice {
    int light = 0;
    float probability = 0.0F;  ///< 0 if nothing shines
    float rest = 0.0F;         ///< uniform again, given the choice
  };

  /// @param u  uniform
  [[nodiscard]] Choice choose(std::uint32_t region, float u) const;
  [[nodiscard]] float probability(std::uint32_t region, int light) const;

 private:
  void add_regions(const Lights& lights, const Patches& patches, const Surfaces& surfaces,
                   const RayTracer& tracer, ThreadPool& pool);
  void estimate(std::uint32_t region, const Lights& lights, const Surfaces& surfaces,
                const RayTracer& tracer, const std::vector<PatchSample>& points);

  int lights_ = 0;
  std::vector<float> cumulative_;  // [regions][lights], the last of each is 1
};

}  // namespace earpoint

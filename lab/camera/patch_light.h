#pragma once

#include "lit_scene.h"
#include "solved_light.h"

#include <cstdint>
#include <vector>

#include <earpoint/core/parallel.h>

namespace earpoint {

/// A ray towards a light, and the irradiance that it brings if nothing is in the way.
struct DirectRay {
  Float3 direction;
  float length_m = 0.0F;  ///< 0: no light to be had here
  Rgb irradiance;
  bool from_lamp = false;
};

/// Draws a light and a place on it. Together with shining_weight() the estimate of direct light is
/// unbiased (balance heuristic: Veach, 1997).
/// @param bounces  how many gathering rays, per ray like this, may meet the same light
DirectRay draw_direct_ray(const LitScene& scene, const Float3& start, const Float3& normal,
                          std::uint32_t region, float choice, UnitPair where, float bounces);

/// The share that a gathering ray (density cos / pi) keeps of the emission that it meets.
/// @param cosine  between the ray and the normal of the surface that it left
float shining_weight(const LitScene& scene, std::uint32_t region, float cosine,
                     const Float3& direction, const Hit& hit, float bounces);

/// The irradiance of every patch: direct light and all diffuse bounces.
/// Source: the radiosity equation, with form factors from cosine-distributed rays.
/// @return  [patches]
std::vector<Rgb> solve_patch_light(const LitScene& scene, ThreadPool& pool);

/// The irradiance of the patches that a scene has beyond one whose light is known, and is taken to
/// stay as it is: the shadow of what came in shows in pictures, whose direct light and first bounce
/// are traced again, but not in the second bounce.
/// @param known        light of the first triangles
/// @param first_patch  the first that is not known
/// @return  [patches from first_patch on]
std::vector<Rgb> solve_added_light(const LitScene& scene, const SolvedLight& known,
                                   std::uint32_t first_patch, ThreadPool& pool);

}  // namespace earpoint

#pragma once

#include "float3.h"
#include "sampling.h"
#include "surfaces.h"

namespace earpoint {

/// Whether a surface has a glossy part that is worth tracing; rougher ones count as diffuse.
bool is_glossy(const SurfaceMaterial& material);

/// Whether it mirrors sharply and does nothing else.
bool is_mirror(const SurfaceMaterial& material);

/// How a surface reflects at a place: a diffuse part and a glossy one, whose strength depends on
/// the angle (Schlick, 1994) and whose width on the roughness (GGX: Walter et al., 2007).
struct Reflection {
  Rgb diffuse;          ///< albedo of the diffuse part
  Rgb facing;           ///< of the glossy part, at normal incidence
  float alpha = 1.0F;   ///< width of the glossy part: the square of the roughness
  bool glossy = false;  ///< whether the glossy part is worth tracing

  /// Matt.
  Reflection() = default;

  /// @param colour  the base colour at this place, texture included
  Reflection(const SurfaceMaterial& material, const Rgb& colour);
};

/// Fresnel's share after Schlick.
/// @param cosine  between the direction and the facet's normal
Rgb fresnel(const Rgb& facing, float cosine);

/// A mirrored direction, drawn in proportion to the facets that are seen.
/// @param viewer  unit direction to the viewer, in the frame whose z is the normal; z > 0
/// @param weight  set to the share of light that comes along it
/// @return  in the same frame; may point below the surface, then without weight
/// Source: Heitz, Sampling the GGX Distribution of Visible Normals, JCGT 7 (2018).
Float3 draw_glossy(const Reflection& reflection, const Float3& viewer, UnitPair sample,
                   Rgb& weight);

/// The glossy part's value for a pair of directions, times the cosine of the light's.
Rgb glossy_times_cosine(const Reflection& reflection, const Float3& viewer, const Float3& light);

}  // namespace earpoint

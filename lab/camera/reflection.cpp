#include "reflection.h"

#include <cmath>

namespace earpoint {
namespace {

constexpr float kDielectricFacing = 0.04F;  // refractive index 1.5
constexpr float kRoughestGloss = 0.55F;     // beyond, the glossy part is taken as diffuse
constexpr float kSmallestAlpha = 1e-3F;

// Smith's term for one direction: the share of facets that are not hidden.
float seen_share(float cosine, float alpha) {
  const float cos2 = cosine * cosine;
  const float tan2 = (1.0F - cos2) / std::max(cos2, 1e-8F);
  return 2.0F / (1.0F + std::sqrt(1.0F + alpha * alpha * tan2));
}

}  // namespace

bool is_glossy(const SurfaceMaterial& material) {
  return material.roughness < kRoughestGloss || material.metallic > 0.0F;
}

bool is_mirror(const SurfaceMaterial& material) {
  return material.metallic > 0.9F && material.roughness < 0.1F;
}

Reflection::Reflection(const SurfaceMaterial& material, const Rgb& colour) {
  const float metallic = material.metallic;
  const float plain = kDielectricFacing * (1.0F - metallic);
  facing = Rgb{plain, plain, plain} + colour * metallic;
  alpha = std::max(kSmallestAlpha, material.roughness * material.roughness);
  glossy = is_glossy(material);
  diffuse = colour * (1.0F - metallic);
}

Rgb fresnel(const Rgb& facing, float cosine) {
  const float c = std::clamp(1.0F - cosine, 0.0F, 1.0F);
  const float c2 = c * c;
  const float rise = c2 * c2 * c;
  return facing + (Rgb{1.0F, 1.0F, 1.0F} - facing) * rise;
}

Float3 draw_glossy(const Reflection& reflection, const Float3& viewer, UnitPair sample,
                   Rgb& weight) {
  const float alpha = reflection.alpha;
  // Stretch the view so that the facets become a hemisphere, and take a point of its visible half.
  const Float3 stretched = normalized(Float3{alpha * viewer.x, alpha * viewer.y, viewer.z});
  const float radius = std::sqrt(sample.u);
  const Turn turn = turn_of(sample.v);
  const float t1 = radius * turn.cosine;
  const float blend = 0.5F * (1.0F + stretched.z);
  const float across = std::sqrt(std::max(0.0F, 1.0F - t1 * t1));
  const Float3 side = stretched.z < 0.9999F ? normalized(cross({0.0F, 0.0F, 1.0F}, stretched))
                                            : Float3{1.0F, 0.0F, 0.0F};
  const Float3 up = cross(stretched, side);
  const float t2 = (1.0F - blend) * across + blend * radius * turn.sine;
  const float t3 = std::sqrt(std::max(0.0F, 1.0F - t1 * t1 - t2 * t2));
  const Float3 bent = side * t1 + up * t2 + stretched * t3;
  const Float3 facet = normalized(Float3{alpha * bent.x, alpha * bent.y, std::max(1e-6F, bent.z)});
  const float cosine = dot(viewer, facet);
  const Float3 direction = facet * (2.0F * cosine) - viewer;
  weight = direction.z > 0.0F ? fresnel(reflection.facing, cosine) * seen_share(direction.z, alpha)
                              : Rgb{};
  return direction;
}

Rgb glossy_times_cosine(const Reflection& reflection, const Float3& viewer, const Float3& light) {
  if (viewer.z <= 0.0F || light.z <= 0.0F) return {};
  const Float3 facet = normalized(viewer + light);
  const float alpha2 = reflection.alpha * reflection.alpha;
  const float base = facet.z * facet.z * (alpha2 - 1.0F) + 1.0F;
  const float density = alpha2 / (kPiF * base * base);
  const float seen = seen_share(viewer.z, reflection.alpha) * seen_share(light.z, reflection.alpha);
  return fresnel(reflection.facing, dot(viewer, facet)) * (density * seen / (4.0F * viewer.z));
}

}  // namespace earpoint

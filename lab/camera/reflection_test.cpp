#include "reflection.h"

#include <gtest/gtest.h>

namespace earpoint {
namespace {

SurfaceMaterial metal(float roughness) {
  SurfaceMaterial material;
  material.roughness = roughness;
  material.metallic = 1.0F;
  return material;
}

// The share of the light of a uniform sky that is reflected, by drawn directions.
float drawn_share(const Reflection& reflection, const Float3& viewer) {
  constexpr std::uint32_t kCount = 16384;
  float sum = 0.0F;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    Rgb weight;
    draw_glossy(reflection, viewer, sobol_pair(i, 5), weight);
    sum += weight.x / kCount;
  }
  return sum;
}

// The same, as a sum of the reflection function over all directions.
float summed_share(const Reflection& reflection, const Float3& viewer) {
  constexpr std::uint32_t kCount = 1U << 18;
  float sum = 0.0F;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const Float3 light = cone_direction(sobol_pair(i, 6), 1.0F);
    sum += glossy_times_cosine(reflection, viewer, light).x * 2.0F * kPiF / kCount;
  }
  return sum;
}

TEST(Reflection, DrawnDirectionsAgreeWithTheFunction) {
  for (const float roughness : {0.35F, 0.6F, 0.9F}) {
    const Reflection reflection(metal(roughness), {0.8F, 0.8F, 0.8F});
    for (const float slant : {0.1F, 0.7F, 1.2F}) {
      const Float3 viewer{std::sin(slant), 0.0F, std::cos(slant)};
      // The sum over 2^18 directions is good to some 1e-3 for the narrowest lobe.
      EXPECT_NEAR(drawn_share(reflection, viewer), summed_share(reflection, viewer), 3e-3F)
          << roughness << " " << slant;
    }
  }
}

TEST(Reflection, NeverReturnsMoreThanItGets) {
  for (const float roughness : {0.05F, 0.3F, 0.6F, 1.0F}) {
    const Reflection reflection(metal(roughness), {1.0F, 1.0F, 1.0F});
    for (const float slant : {0.0F, 0.8F, 1.4F}) {
      const float share = drawn_share(reflection, {std::sin(slant), 0.0F, std::cos(slant)});
      EXPECT_LE(share, 1.0001F);  // float sums
      // The model lacks light that is reflected between facets: the loss grows with roughness and
      // slant.
      EXPECT_GE(share, roughness < 0.4F ? 0.85F : 0.25F);
    }
  }
}

TEST(Reflection, SmoothMetalIsAMirror) {
  const Reflection reflection(metal(0.0F), {1.0F, 1.0F, 1.0F});
  Rgb weight;
  const Float3 viewer = normalized(Float3{0.5F, 0.3F, 0.6F});
  const Float3 out = draw_glossy(reflection, viewer, {0.4F, 0.7F}, weight);
  // At the smallest roughness the facets are tilted by about 1e-3 rad; several of that.
  EXPECT_NEAR(norm(out - Float3{-viewer.x, -viewer.y, viewer.z}), 0.0F, 5e-3F);
}

TEST(Reflection, PlainSurfacesMirrorFourPercentHeadOnAndAllAtGrazing) {
  const Reflection reflection(SurfaceMaterial{.roughness = 0.2F}, {0.5F, 0.5F, 0.5F});
  EXPECT_TRUE(reflection.glossy);
  EXPECT_FLOAT_EQ(fresnel(reflection.facing, 1.0F).x, 0.04F);
  EXPECT_FLOAT_EQ(fresnel(reflection.facing, 0.0F).x, 1.0F);
  EXPECT_EQ(reflection.diffuse.x, 0.5F);
  EXPECT_FALSE(Reflection(SurfaceMaterial{.roughness = 0.9F}, {0.5F, 0.5F, 0.5F}).glossy);
}

}  // namespace
}  // namespace earpoint

#pragma once

#include <array>
#include <string>

#include <earpoint/core/octave_bands.h>

namespace earpoint {

/// What a surface does to sound, per octave band; every number is a share of energy in [0, 1].
struct AcousticMaterial {
  std::string name;
  BandArray absorption{};    ///< of the incident energy: what is not reflected
  BandArray scattering{};    ///< of the reflected energy: what leaves diffusely (ISO 17497-1)
  BandArray transmission{};  ///< of the incident energy: what goes through; at most `absorption`
  std::string source;        ///< where the numbers come from
};

/// What a surface looks like. Colours are linear light, red, green, blue.
struct Look {
  std::array<float, 3> base_colour{0.7F, 0.7F, 0.7F};  ///< in [0, 1]; multiplies the texture
  int texture = kNoTexture;                            ///< index into `Scene::textures`
  float roughness = 0.8F;                              ///< 0 mirror, 1 matt
  float metallic = 0.0F;
  float opacity = 1.0F;
  std::array<float, 3> emission{};  ///< radiance; 1 is white at an exposure of 1

  static constexpr int kNoTexture = -1;
};

struct Material {
  AcousticMaterial acoustic;
  Look look;
};

}  // namespace earpoint

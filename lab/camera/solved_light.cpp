#include "solved_light.h"

namespace earpoint {

SolvedLight::SolvedLight(const LitScene& scene, const std::vector<Rgb>& irradiance) {
  append(scene, 0, irradiance);
}

SolvedLight::SolvedLight(const SolvedLight& base, const LitScene& scene, std::uint32_t first_patch,
                         const std::vector<Rgb>& irradiance)
    : SolvedLight(base) {
  append(scene, first_patch, irradiance);
}

void SolvedLight::append(const LitScene& scene, std::uint32_t first_patch,
                         const std::vector<Rgb>& irradiance) {
  const Surfaces& surfaces = scene.surfaces;
  radiance_.resize(scene.patches.bins());
  records_.reserve(surfaces.triangles());
  for (std::uint32_t triangle = triangles(); triangle < surfaces.triangles(); ++triangle) {
    const TriangleCut& cut = scene.patches.cut(triangle);
    records_.push_back({surfaces.face_normal(triangle), cut,
                        largest(surfaces.material(triangle).mean_emission) > 0.0F});
    const Rgb share = surfaces.material(triangle).reflectance * (1.0F / kPiF);
    for (std::size_t bin = cut.first_bin(); bin < cut.first_bin() + cut.bins(); ++bin) {
      radiance_[bin] = share * irradiance[scene.patches.patch_of_bin(bin) - first_patch];
    }
  }
}

}  // namespace earpoint

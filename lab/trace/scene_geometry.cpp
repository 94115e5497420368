#include "scene_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/trace/acoustic_scene.h>

namespace earpoint {
namespace {

// Smaller planes are below the first Fresnel zone for most audible frequencies at room distances
// and do not act as mirrors.
constexpr double kSmallestMirrorSquareMetres = 0.25;

std::vector<BounceSurface> make_surfaces(const Scene& scene) {
  std::vector<BounceSurface> surfaces;
  for (const Material& material : scene.materials) {
    const AcousticMaterial& acoustic = material.acoustic;
    BounceSurface surface;
    for (int band = 0; band < kOctaveBands; ++band) {
      const float reflected = 1.0F - acoustic.absorption[band];
      surface.diffuse[band] = reflected * acoustic.scattering[band];
      surface.specular[band] = reflected * (1.0F - acoustic.scattering[band]);
      surface.transmitted[band] = acoustic.transmission[band];
      surface.transmits = surface.transmits || acoustic.transmission[band] > 0.0F;
      surface.most_specular = std::max(surface.most_specular, surface.specular[band]);
      surface.purity = std::max(surface.purity, 1.0F - acoustic.scattering[band]);
    }
    surfaces.push_back(surface);
  }
  return surfaces;
}

std::vector<LayerMask> make_instance_layers(const Scene& scene) {
  std::vector<LayerMask> layers;
  int people = 0;
  for (const Instance& instance : scene.instances) {
    layers.push_back(instance.kind == InstanceKind::person ? person_layer(people++) : kOpaqueLayer);
  }
  return layers;
}

std::vector<LayerMask> make_layers(const Mesh& mesh, const std::vector<BounceSurface>& surfaces,
                                   const std::vector<LayerMask>& instance_layers) {
  std::vector<LayerMask> layers;
  layers.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    EARPOINT_CHECK(mesh.triangle_material[i] < surfaces.size());
    EARPOINT_CHECK(mesh.triangle_instance[i] < instance_layers.size());
    const bool transmits = surfaces[mesh.triangle_material[i]].transmits;
    layers.push_back(transmits ? kTransmissiveLayer : instance_layers[mesh.triangle_instance[i]]);
  }
  return layers;
}

// The planes of the mesh, to about half a degree and a centimetre, with the area that lies in them.
using PlaneKey = std::array<int, 4>;
PlaneKey plane_key(const Vector3& normal, double offset_m) {
  constexpr double kNormalSteps = 100.0;
  constexpr double kOffsetSteps_per_m = 100.0;
  // Both sides of a plane are one plane, so the first non-zero component is made positive.
  const bool flip =
      normal.x < -1e-6 || (std::abs(normal.x) <= 1e-6 &&
                           (normal.y < -1e-6 || (std::abs(normal.y) <= 1e-6 && normal.z < 0.0)));
  const double sign = flip ? -1.0 : 1.0;
  const auto round = [](double value) { return static_cast<int>(std::lround(value)); };
  return {round(sign * normal.x * kNormalSteps), round(sign * normal.y * kNormalSteps),
          round(sign * normal.z * kNormalSteps), round(sign * offset_m * kOffsetSteps_per_m)};
}

std::vector<BounceFacet> make_facets(const Mesh& mesh) {
  std::vector<BounceFacet> facets(mesh.triangles.size());
  std::map<PlaneKey, double> areas_m2;
  std::vector<const double*> plane_area(mesh.triangles.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const Vector3 scaled = scaled_normal(mesh, i);
    const Vector3 normal = normalized(scaled);
    facets[i].normal = {static_cast<float>(normal.x), static_cast<float>(normal.y),
                        static_cast<float>(normal.z)};
    facets[i].surface = mesh.triangle_material[i];
    facets[i].exact_normal = normal;
    facets[i].offset_m = dot(normal, vertex(mesh, mesh.triangles[i][0]));
    double& area_m2 = areas_m2[plane_key(normal, facets[i].offset_m)];
    area_m2 += norm(scaled) / 2.0;
    plane_area[i] = &area_m2;
  }
  for (std::size_t i = 0; i < facets.size(); ++i) {
    facets[i].mirror = *plane_area[i] >= kSmallestMirrorSquareMetres;
  }
  return facets;
}

double largest_coordinate_m(const Mesh& mesh) {
  const Bounds box = bounds(mesh);
  double largest_m = 0.0;
  for (const Vector3& corner : {box.low, box.high}) {
    largest_m = std::max({largest_m, std::abs(corner.x), std::abs(corner.y), std::abs(corner.z)});
  }
  return largest_m;
}

}  // namespace

SceneGeometry::SceneGeometry(const Scene& scene)
    : mesh_(scene.mesh),
      surfaces_(make_surfaces(scene)),
      facets_(make_facets(mesh_)),
      instance_layers_(make_instance_layers(scene)),
      transmits_(std::any_of(surfaces_.begin(), surfaces_.end(),
                             [](const BounceSurface& surface) { return surface.transmits; })),
      // A float's step at the room's far end is 6e-8 of the coordinate; a hit is precise to a few
      // steps.
      surface_offset_m_(1e-4 + 1e-6 * largest_coordinate_m(mesh_)),
      rays_(mesh_, make_layers(mesh_, surfaces_, instance_layers_)) {
  mesh_.normals.clear();
  mesh_.uvs.clear();
  for (const Instance& instance : scene.instances) instance_kinds_.push_back(instance.kind);
  edges_ = find_diffraction_edges(*this);
  edge_pairs_ = find_edge_pairs(edges_);
  edge_groups_ = group_edges(edges_.size(), edge_pairs_);
  facing_pairs_ = find_facing_pairs(*this, edges_, edge_pairs_);
}

LayerMask SceneGeometry::mask_without(std::optional<std::uint32_t> body) const {
  if (!body) return kAllLayers;
  EARPOINT_CHECK(*body < instance_layers_.size());
  EARPOINT_CHECK(instance_layers_[*body] != kOpaqueLayer);
  return kAllLayers & ~instance_layers_[*body];
}

bool SceneGeometry::transmit(const Vector3& from, const Vector3& to, LayerMask mask,
                             BandArray& energy) const {
  if (rays_.occluded(from, to, mask & ~kTransmissiveLayer)) return false;
  if (!transmits_ || (mask & kTransmissiveLayer) == 0) return true;
  const double distance_m = norm(to - from);
  const Vector3 direction = (to - from) / distance_m;
  double passed_m = 0.0;
  const BounceFacet* entered = nullptr;
  double entered_m = 0.0;
  while (passed_m < distance_m) {
    const std::optional<TriangleHit> hit = rays_.closest(
        from + direction * passed_m, direction, distance_m - passed_m, mask & kTransmissiveLayer);
    if (!hit) return true;
    const BounceFacet& facet = facets_[hit->triangle];
    const double hit_m = passed_m + static_cast<double>(hit->distance_m);
    passed_m = hit_m + surface_offset_m_;
    const double across_m = (hit_m - entered_m) * std::abs(dot(direction, facet.exact_normal));
    if (entered != nullptr && is_other_side(*entered, facet, across_m)) {
      entered = nullptr;
      continue;
    }
    entered = &facet;
    entered_m = hit_m;
    const BounceSurface& wall = surface(facet);
    float most = 0.0F;
    for (int band = 0; band < kOctaveBands; ++band) {
      energy[band] *= wall.transmitted[band];
      most = std::max(most, energy[band]);
    }
    if (most <= 0.0F) return false;
  }
  return true;
}

bool SceneGeometry::is_other_side(const BounceFacet& passed, const BounceFacet& next,
                                  double across_m) {
  constexpr double kThickest_m = 0.4;
  constexpr double kParallel = 0.99;  // within 8 degrees
  return passed.surface == next.surface && across_m <= kThickest_m &&
         std::abs(dot(passed.exact_normal, next.exact_normal)) > kParallel;
}

AcousticScene::AcousticScene(const Scene& scene)
    : geometry_(std::make_unique<const SceneGeometry>(scene)) {}
AcousticScene::~AcousticScene() = default;
AcousticScene::AcousticScene(AcousticScene&&) noexcept = default;
AcousticScene& AcousticScene::operator=(AcousticScene&&) noexcept = default;

}  // namespace earpoint

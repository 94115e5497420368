#include "lights.h"

#include <cmath>
#include <map>
#include <tuple>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr float kSmallestLampM = 0.01F;
constexpr float kNearM = 0.3F;
constexpr std::size_t kMostGroups = 256;

}  // namespace

Lights::Lights(const Surfaces& surfaces, std::span<const Lamp> lamps) : surfaces_(&surfaces) {
  for (const Lamp& lamp : lamps) {
    Light light;
    light.centre = float3(lamp.position_m);
    light.radius_m = std::max(lamp.radius_m, kSmallestLampM);
    // A ball of radiance L has the intensity L pi r^2 in every direction.
    light.radiance = float3(lamp.intensity) * (1.0F / (kPiF * light.radius_m * light.radius_m));
    if (largest(light.radiance) > 0.0F) lights_.push_back(light);
  }
  lamps_ = size();
  gather_groups();
}

Lights::Lights(const Lights& base, const Surfaces& surfaces) : Lights(base) {
  for (std::uint32_t i = base.surfaces_->triangles(); i < surfaces.triangles(); ++i) {
    EARPOINT_CHECK(!(largest(surfaces.material(i).mean_emission) > 0.0F));
  }
  surfaces_ = &surfaces;
  if (!triangle_light_.empty()) triangle_light_.resize(surfaces.triangles(), -1);
}

void Lights::gather_groups() {
  std::vector<std::uint32_t> shining;
  for (std::uint32_t i = 0; i < surfaces_->triangles(); ++i) {
    if (largest(surfaces_->material(i).mean_emission) > 0.0F && surfaces_->area_m2(i) > 0.0F) {
      shining.push_back(i);
    }
  }
  if (shining.empty()) return;

  // Triangles of one material in one cube of a grid are one light; the grid widens until there are
  // few enough.
  using Key = std::tuple<std::uint32_t, int, int, int>;
  std::map<Key, std::vector<std::uint32_t>> groups;
  for (float width_m = 2.0F; groups.empty() || groups.size() > kMostGroups; width_m *= 2.0F) {
    groups.clear();
    const auto cell = [&](float coordinate) {
      return static_cast<int>(std::floor(coordinate / width_m));
    };
    for (const std::uint32_t i : shining) {
      const Float3 middle = surfaces_->position(i, 1.0F / 3.0F, 1.0F / 3.0F);
      // In the widest grid all materials share one group.
      const std::uint32_t material = width_m < 1e4F ? surfaces_->material_index(i) : 0;
      groups[{material, cell(middle.x), cell(middle.y), cell(middle.z)}].push_back(i);
    }
  }

  triangle_light_.assign(surfaces_->triangles(), -1);
  for (const auto& [key, triangles] : groups) {
    Light light;
    light.first = static_cast<std::uint32_t>(members_.size());
    light.count = static_cast<std::uint32_t>(triangles.size());
    for (const std::uint32_t i : triangles) {
      light.area_m2 += surfaces_->area_m2(i);
      members_.push_back(i);
      member_cumulative_area_.push_back(light.area_m2);
      triangle_light_[i] = size();
    }
    lights_.push_back(light);
  }
}

LightSample Lights::sample(int light, const Float3& from, float which, UnitPair where) const {
  const Light& l = lights_[static_cast<std::size_t>(light)];
  return light < lamps_ ? sample_lamp(l, from, where) : sample_group(l, from, which, where);
}

LightSample Lights::sample_lamp(const Light& lamp, const Float3& from, UnitPair where) const {
  const Float3 offset = lamp.centre - from;
  // Inside the lamp's ball the light is as at its surface.
  const float distance = std::max(norm(offset), 1.001F * lamp.radius_m);
  const float sine = lamp.radius_m / distance;
  const float cos_limit = std::sqrt(std::max(0.0F, 1.0F - sine * sine));
  // 1 - cos, without the loss of digits for far lamps.
  const float height = sine * sine / (1.0F + cos_limit);
  LightSample sample;
  const Float3 axis = norm(offset) > 0.0F ? normalized(offset) : Float3{0.0F, 0.0F, 1.0F};
  sample.direction = Frame(axis).to_world(cone_direction(where, height));
  sample.distance_m = distance - lamp.radius_m;
  // Lamps stand for bulbs in shades: closer than the size of a shade the light grows no brighter.
  const float near = std::min(1.0F, distance / kNearM);
  sample.radiance = lamp.radiance * (near * near);
  sample.density = 1.0F / (2.0F * kPiF * height);
  return sample;
}

LightSample Lights::sample_group(const Light& group, const Float3& from, float which,
                                 UnitPair where) const {
  const auto begin = member_cumulative_area_.begin() + group.first;
  const auto end = begin + group.count;
  const auto found = std::min(std::upper_bound(begin, end, which * group.area_m2), end - 1);
  const std::uint32_t triangle =
      members_[static_cast<std::size_t>(found - member_cumulative_area_.begin())];
  const float root = std::sqrt(where.u);
  const Float3 place = surfaces_->position(triangle, root * (1.0F - where.v), root * where.v);
  const Float3 offset = place - from;
  LightSample sample;
  const float distance = norm(offset);
  if (!(distance > 0.0F)) return sample;
  sample.direction = offset * (1.0F / distance);
  // Stop short of the shining triangle itself.
  sample.distance_m = distance * 0.9999F - 1e-4F;
  const float cosine = std::abs(dot(sample.direction, surfaces_->face_normal(triangle)));
  if (!(cosine > 1e-5F) || sample.distance_m <= 0.0F) return sample;
  const SurfaceMaterial& material = surfaces_->material(triangle);
  sample.radiance = material.mean_emission * material.opacity;
  sample.density = distance * distance / (cosine * group.area_m2);
  return sample;
}

float Lights::density(int light, float distance_m, float cosine) const {
  const Light& group = lights_[static_cast<std::size_t>(light)];
  if (!(cosine > 1e-5F)) return 0.0F;
  return distance_m * distance_m / (cosine * group.area_m2);
}

Rgb Lights::lamps_along(const Float3& start, const Float3& direction, float length_m) const {
  Rgb sum;
  for (int i = 0; i < lamps_; ++i) {
    const Light& lamp = lights_[static_cast<std::size_t>(i)];
    const Float3 offset = lamp.centre - start;
    const float along = dot(offset, direction);
    if (along <= 0.0F || along > length_m) continue;
    const float aside2 = dot(offset, offset) - along * along;
    if (aside2 < lamp.radius_m * lamp.radius_m) sum += lamp.radiance;
  }
  return sum;
}

}  // namespace earpoint

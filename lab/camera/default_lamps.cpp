#include "default_lamps.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace earpoint {
namespace {

constexpr float kSpacingM = 3.0F;
constexpr int kMostAlongAxis = 16;
constexpr float kBelowCeilingM = 0.35F;
constexpr float kLowestRoomM = 1.8F;
constexpr float kHighestRoomM = 12.0F;
constexpr int kMostStoreys = 8;
constexpr Lamp kLamp{.position_m = {}, .intensity = {2.0F, 1.85F, 1.6F}, .radius_m = 0.12F};

// Heights of all surfaces on a vertical line, lowest first.
std::vector<float> heights_on_line(const RayTracer& tracer, float x, float y, float bottom) {
  std::vector<float> heights;
  float z = bottom - 1.0F;
  for (int i = 0; i < 4 * kMostStoreys; ++i) {
    RayPacket packet;
    packet.set(0, {x, y, z}, {0.0F, 0.0F, 1.0F}, std::numeric_limits<float>::infinity(), 0);
    tracer.trace(packet, RayTracer::Rays::mixed, SeeThrough::if_mostly_so, 0);
    Hit hit;
    if (!tracer.hit(packet, 0, hit)) break;
    z += hit.distance_m;
    heights.push_back(z);
    z += 1e-3F;
  }
  return heights;
}

// The middle of each part of an axis, moved off the exact middle, where walls often stand.
std::vector<float> places_along(double low, double high) {
  const double length = high - low;
  const int count =
      std::clamp(static_cast<int>(std::lround(length / kSpacingM)), 1, kMostAlongAxis);
  std::vector<float> places;
  places.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    places.push_back(static_cast<float>(low + length * (i + 0.49) / count));
  }
  return places;
}

}  // namespace

std::vector<Lamp> lamps_of(const Scene& scene, const Surfaces& surfaces, const RayTracer& tracer,
                           bool light_dark_scenes) {
  if (!light_dark_scenes || !scene.lamps.empty()) return scene.lamps;
  for (std::uint32_t i = 0; i < surfaces.triangles(); ++i) {
    if (largest(surfaces.material(i).emission) > 0.0F) return {};
  }
  std::vector<Lamp> lamps;
  const Bounds box = bounds(scene.mesh);
  for (const float x : places_along(box.low.x, box.high.x)) {
    for (const float y : places_along(box.low.y, box.high.y)) {
      const std::vector<float> heights =
          heights_on_line(tracer, x, y, static_cast<float>(box.low.z));
      for (std::size_t i = 1; i < heights.size(); ++i) {
        const float gap = heights[i] - heights[i - 1];
        if (gap < kLowestRoomM || gap > kHighestRoomM) continue;
        Lamp lamp = kLamp;
        lamp.position_m = {x, y, heights[i] - kBelowCeilingM};
        lamps.push_back(lamp);
      }
    }
  }
  return lamps;
}

}  // namespace earpoint

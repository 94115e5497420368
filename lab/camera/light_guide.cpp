#include "light_guide.h"

#include <algorithm>

namespace earpoint {
namespace {

constexpr std::size_t kPoints = 16;  // per region: one packet of rays to each light
constexpr std::uint32_t kSeed = 0x6D2B79F5U;
// Share that a light keeps where no test ray reached it, as it may still shine there.
constexpr float kUniformShare = 0.03F;

// For every region, points spread over its patches.
std::vector<std::vector<PatchSample>> points_of_regions(const Patches& patches) {
  std::vector<std::vector<std::uint32_t>> members(patches.regions());
  for (std::uint32_t patch = 0; patch < patches.size(); ++patch) {
    members[patches.region(patch)].push_back(patch);
  }
  std::vector<std::vector<PatchSample>> points(patches.regions());
  for (std::uint32_t region = 0; region < patches.regions(); ++region) {
    const std::size_t count = members[region].size();
    for (std::size_t k = 0; k < kPoints; ++k) {
      const std::uint32_t patch = members[region][(2 * k + 1) * count / (2 * kPoints) % count];
      points[region].push_back(patches.samples(patch)[k % Patches::kSamples]);
    }
  }
  return points;
}

}  // namespace

LightGuide::LightGuide(const Lights& lights, const Patches& patches, const Surfaces& surfaces,
                       const RayTracer& tracer, ThreadPool& pool)
    : lights_(lights.size()) {
  add_regions(lights, patches, surfaces, tracer, pool);
}

LightGuide::LightGuide(const LightGuide& base, const Lights& lights, const Patches& patches,
                       const Surfaces& surfaces, const RayTracer& tracer, ThreadPool& pool)
    : LightGuide(base) {
  add_regions(lights, patches, surfaces, tracer, pool);
}

void LightGuide::add_regions(const Lights& lights, const Patches& patches, const Surfaces& surfaces,
                             const RayTracer& tracer, ThreadPool& pool) {
  if (lights_ == 0) return;
  const auto first = static_cast<std::uint32_t>(cumulative_.size() / lights_);
  cumulative_.resize(static_cast<std::size_t>(patches.regions()) * lights_);
  const std::vector<std::vector<PatchSample>> points = points_of_regions(patches);
  pool.run(patches.regions() - first, [&](std::ptrdiff_t task, int) {
    const auto region = first + static_cast<std::uint32_t>(task);
    estimate(region, lights, surfaces, tracer, points[region]);
  });
}

void LightGuide::estimate(std::uint32_t region, const Lights& lights, const Surfaces& surfaces,
                          const RayTracer& tracer, const std::vector<PatchSample>& points) {
  float* cumulative = &cumulative_[static_cast<std::size_t>(region) * lights_];
  RayPacket packet;
  float sum = 0.0F;
  for (int light = 0; light < lights_; ++light) {
    packet.clear();
    std::array<float, kPoints> arriving{};
    float weight = 0.0F;
    for (std::size_t k = 0; k < kPoints; ++k) {
      const PatchSample& point = points[k];
      const UnitPair where = sobol_pair(static_cast<std::uint32_t>(k), hash_words(kSeed, region));
      const float which = unit_from_bits(hash_words(static_cast<std::uint32_t>(k), region));
      const LightSample sample = lights.sample(light, point.position, which, where);
      if (sample.density <= 0.0F) continue;
      const float unhindered = luminance(sample.radiance) / sample.density;
      weight += kUniformShare * unhindered;
      const float cosine = dot(sample.direction, point.normal);
      if (cosine <= 0.0F) continue;
      arriving[k] = unhindered * cosine;
      packet.set(static_cast<int>(k), surfaces.ray_start(point.position, point.normal),
                 sample.direction, sample.distance_m, static_cast<std::uint32_t>(k));
    }
    const std::array<bool, RayPacket::kRays> reached = tracer.reaches_end(packet, region);
    for (std::size_t k = 0; k < kPoints; ++k) {
      if (reached[k]) weight += arriving[k];
    }
    sum += weight;
    cumulative[light] = sum;
  }
  for (int light = 0; light < lights_; ++light) {
    cumulative[light] = sum > 0.0F ? cumulative[light] / sum
                                   : static_cast<float>(light + 1) / static_cast<float>(lights_);
  }
  cumulative[lights_ - 1] = 1.0F;
}

LightGuide::Choice LightGuide::choose(std::uint32_t region, float u) const {
  if (lights_ == 0) return {};
  const float* begin = &cumulative_[static_cast<std::size_t>(region) * lights_];
  const auto light = static_cast<int>(
      std::min<std::ptrdiff_t>(std::upper_bound(begin, begin + lights_, u) - begin, lights_ - 1));
  const float low = light > 0 ? begin[light - 1] : 0.0F;
  return {light, begin[light] - low, rescale(u, low, begin[light])};
}

float LightGuide::probability(std::uint32_t region, int light) const {
  const float* begin = &cumulative_[static_cast<std::size_t>(region) * lights_];
  return begin[light] - (light > 0 ? begin[light - 1] : 0.0F);
}

}  // namespace earpoint

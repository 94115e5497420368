#include "patch_light.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace earpoint {
namespace {

constexpr int kGatheringRays = 64;  // per patch
constexpr int kDirectRays = 16;     // per patch
constexpr float kBouncesPerDirectRay = static_cast<float>(kGatheringRays) / kDirectRays;
constexpr std::uint32_t kSeed = 0x85EBCA6BU;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Far below what an eye or 8 bits can tell apart.
constexpr float kConverged = 1e-4F;
constexpr int kMostBounces = 400;  // 0.95^400 = 1e-9

// What a gathering ray of a patch hit.
struct Link {
  static constexpr std::uint32_t kNothing = ~0U;
  std::uint32_t patch = kNothing;
  std::uint32_t material = 0;
};

// The starting light and the links of one patch.
class PatchGatherer {
 public:
  // @param known  light of the first triangles, or null
  PatchGatherer(const LitScene& scene, const SolvedLight* known, std::uint32_t patch)
      : scene_(scene),
        known_(known),
        patch_(patch),
        region_(scene.patches.region(patch)),
        seed_(hash_words(kSeed, patch)) {}

  Rgb direct() {
    Rgb sum;
    RayPacket packet;
    std::array<Rgb, kDirectRays> irradiance;
    for (int k = 0; k < kDirectRays; ++k) {
      const PatchSample& sample = scene_.patches.samples(patch_)[k % Patches::kSamples];
      const auto index = static_cast<std::uint32_t>(k);
      const Float3 start = scene_.surfaces.ray_start(sample.position, sample.normal);
      const DirectRay ray = draw_direct_ray(
          scene_, start, sample.normal, region_, sobol_pair(index, hash_words(seed_, 1)).u,
          sobol_pair(index, hash_words(seed_, 2)), kBouncesPerDirectRay);
      if (ray.length_m <= 0.0F) continue;
      irradiance[k] = ray.irradiance;
      packet.set(k, start, ray.direction, ray.length_m, index);
    }
    const std::array<bool, RayPacket::kRays> reached = scene_.tracer.reaches_end(packet, seed_);
    for (int k = 0; k < kDirectRays; ++k) {
      if (reached[k]) sum += irradiance[k];
    }
    return sum * (1.0F / kDirectRays);
  }

  // Fills the links and sets `rays` to their number. Returns the light that the rays gathered from
  // the sky, from emitting surfaces and from surfaces of known light.
  Rgb gather(Link* links, int& rays) {
    Rgb sum;
    for (rays = 0; rays < kGatheringRays && !(rays > 0 && sees_no_front_);
         rays += RayPacket::kRays) {
      const int first = rays;
      RayPacket packet;
      std::array<Float3, RayPacket::kRays> directions;
      std::array<float, RayPacket::kRays> cosines{};
      for (int lane = 0; lane < RayPacket::kRays; ++lane) {
        const int k = first + lane;
        const PatchSample& sample = scene_.patches.samples(patch_)[k % Patches::kSamples];
        const auto index = static_cast<std::uint32_t>(k);
        const Float3 local = cosine_direction(sobol_pair(index, hash_words(seed_, 3)));
        directions[lane] = Frame(sample.normal).to_world(local);
        cosines[lane] = local.z;
        packet.set(lane, scene_.surfaces.ray_start(sample.position, sample.normal),
                   directions[lane], kInfinity, index);
      }
      scene_.tracer.trace(packet, RayTracer::Rays::mixed, SeeThrough::by_chance, seed_);
      for (int lane = 0; lane < RayPacket::kRays; ++lane) {
        sum += take(packet, lane, directions[lane], cosines[lane], links[first + lane]);
      }
    }
    return sum * (kPiF / static_cast<float>(rays));
  }

 private:
  Rgb take(const RayPacket& packet, int lane, const Float3& direction, float cosine, Link& link) {
    Hit hit;
    if (!scene_.tracer.hit(packet, lane, hit)) return scene_.sky;
    const bool front = dot(scene_.surfaces.face_normal(hit.triangle), direction) <= 0.0F;
    sees_no_front_ = sees_no_front_ && !front;
    if (known_ != nullptr && hit.triangle < known_->triangles()) {
      return known_->radiance(hit, direction, {0.5F, 0.5F}) + shining(hit, direction, cosine);
    }
    link.patch = scene_.patches.at(hit.triangle, hit.u, hit.v, front);
    link.material = scene_.surfaces.material_index(hit.triangle);
    return shining(hit, direction, cosine);
  }

  [[nodiscard]] Rgb shining(const Hit& hit, const Float3& direction, float cosine) const {
    const float share =
        shining_weight(scene_, region_, cosine, direction, hit, kBouncesPerDirectRay);
    return scene_.surfaces.material(hit.triangle).mean_emission * share;
  }

  const LitScene& scene_;
  const SolvedLight* known_;
  // Inside of things and behind walls rays hit only back sides, or nothing. These patches are not
  // seen, so the first packet of rays is enough.
  bool sees_no_front_ = true;
  std::uint32_t patch_;
  std::uint32_t region_;
  std::uint32_t seed_;
};

}  // namespace

DirectRay draw_direct_ray(const LitScene& scene, const Float3& start, const Float3& normal,
                          std::uint32_t region, float choice, UnitPair where, float bounces) {
  DirectRay ray;
  const LightGuide::Choice chosen = scene.guide.choose(region, choice);
  if (chosen.probability <= 0.0F) return ray;
  const LightSample sample = scene.lights.sample(chosen.light, start, chosen.rest, where);
  const float cosine = dot(sample.direction, normal);
  if (sample.density <= 0.0F || cosine <= 0.0F) return ray;
  const float density = chosen.probability * sample.density;
  // Gathering rays hit groups of emitting triangles, but never lamps.
  ray.from_lamp = scene.lights.is_lamp(chosen.light);
  const float rival = ray.from_lamp ? 0.0F : bounces * cosine / kPiF;
  ray.direction = sample.direction;
  ray.length_m = sample.distance_m;
  ray.irradiance = sample.radiance * (cosine / (density + rival));
  return ray;
}

float shining_weight(const LitScene& scene, std::uint32_t region, float cosine,
                     const Float3& direction, const Hit& hit, float bounces) {
  const int light = scene.lights.light_of(hit.triangle);
  if (light < 0) return 0.0F;
  const float own = bounces * cosine / kPiF;
  const float facing = std::abs(dot(direction, scene.surfaces.face_normal(hit.triangle)));
  const float rival =
      scene.guide.probability(region, light) * scene.lights.density(light, hit.distance_m, facing);
  return own > 0.0F ? own / (own + rival) : 0.0F;
}

namespace {

// Light that the patches from the first one on receive through the links between them.
std::vector<Rgb> solve(const LitScene& scene, const SolvedLight* known, std::uint32_t first_patch,
                       ThreadPool& pool) {
  const std::size_t patches = scene.patches.size() - first_patch;
  std::vector<Link> links(patches * kGatheringRays);
  std::vector<int> rays(patches);
  std::vector<Rgb> start(patches);
  constexpr std::size_t kPatchesPerTask = 64;
  const std::size_t tasks = (patches + kPatchesPerTask - 1) / kPatchesPerTask;
  const auto each_patch = [&](auto body) {
    pool.run(static_cast<std::ptrdiff_t>(tasks), [&](std::ptrdiff_t task, int) {
      const std::size_t first = static_cast<std::size_t>(task) * kPatchesPerTask;
      for (std::size_t i = first; i < std::min(patches, first + kPatchesPerTask); ++i) body(i);
    });
  };
  each_patch([&](std::size_t i) {
    PatchGatherer gatherer(scene, known, first_patch + static_cast<std::uint32_t>(i));
    start[i] = gatherer.direct() + gatherer.gather(&links[i * kGatheringRays], rays[i]);
  });

  // Jacobi's iteration adds one bounce each time. Each writes a second array, so that the order of
  // work does not matter.
  std::vector<Rgb> light = start;
  std::vector<Rgb> next(patches);
  std::vector<float> change(patches);
  for (int bounce = 0; bounce < kMostBounces && patches > 0; ++bounce) {
    each_patch([&](std::size_t i) {
      Rgb sum;
      const Link* first = &links[i * kGatheringRays];
      for (const Link* link = first; link != first + rays[i]; ++link) {
        if (link->patch == Link::kNothing) continue;
        sum += scene.surfaces.materials()[link->material].reflectance *
               light[link->patch - first_patch];
      }
      next[i] = start[i] + sum * (1.0F / static_cast<float>(rays[i]));
      change[i] = largest(next[i] - light[i]) - kConverged * largest(next[i]);
    });
    light.swap(next);
    if (*std::max_element(change.begin(), change.end()) <= 0.0F) break;
  }
  return light;
}

}  // namespace

std::vector<Rgb> solve_patch_light(const LitScene& scene, ThreadPool& pool) {
  return solve(scene, nullptr, 0, pool);
}

std::vector<Rgb> solve_added_light(const LitScene& scene, const SolvedLight& known,
                                   std::uint32_t first_patch, ThreadPool& pool) {
  return solve(scene, &known, first_patch, pool);
}

}  // namespace earpoint

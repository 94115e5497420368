#include <earpoint/camera/scene_drawer.h>

#include "default_lamps.h"
#include "denoise.h"
#include "develop.h"
#include "patch_light.h"
#include "solved_light.h"
#include "view_sampler.h"

#include <utility>
#include <vector>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kMostSamplesPerSide = 32;

void check_quality(const RenderQuality& quality) {
  EARPOINT_CHECK(quality.samples_per_side >= 1 && quality.samples_per_side <= kMostSamplesPerSide);
  EARPOINT_CHECK(quality.exposure > 0.0F);
}

PixelRegion whole_picture(const Camera& camera) {
  return {.width = camera.width, .height = camera.height};
}

struct TracedView {
  View view;
  PixelBuffers buffers;
  std::vector<PlaceLight> light;
};

}  // namespace

struct SceneDrawer::Parts {
  Parts(const Scene& scene, const Lighting& lighting, ThreadPool& pool)
      : surfaces(scene),
        tracer(surfaces),
        patches(surfaces),
        lights(surfaces, lamps_of(scene, surfaces, tracer, lighting.light_dark_scenes)),
        guide(lights, patches, surfaces, tracer, pool),
        sky(float3(lighting.sky_radiance)),
        own_lamps(scene.lamps.size()),
        solved(lit_scene(), solve_patch_light(lit_scene(), pool)) {}

  /// For a scene that begins with the scene of `base`.
  Parts(const Parts& base, const Scene& scene, ThreadPool& pool)
      : surfaces(base.surfaces, scene),
        tracer(surfaces),
        patches(base.patches, surfaces),
        lights(base.lights, surfaces),
        guide(base.guide, lights, patches, surfaces, tracer, pool),
        sky(base.sky),
        own_lamps(base.own_lamps),
        solved(base.solved, lit_scene(), base.patches.size(),
               solve_added_light(lit_scene(), base.solved, base.patches.size(), pool)) {
    EARPOINT_CHECK(scene.lamps.size() == own_lamps);
  }

  [[nodiscard]] LitScene lit_scene() const {
    return {surfaces, tracer, patches, lights, guide, sky};
  }

  [[nodiscard]] TracedView trace(const Camera& camera, const PixelRegion& region,
                                 const RenderQuality& quality, std::uint64_t seed,
                                 ThreadPool& pool) const;

  Surfaces surfaces;
  RayTracer tracer;
  Patches patches;
  Lights lights;
  LightGuide guide;
  Rgb sky;
  std::size_t own_lamps;  // of the scene, without default lamps in dark rooms
  SolvedLight solved;
};

TracedView SceneDrawer::Parts::trace(const Camera& camera, const PixelRegion& region,
                                     const RenderQuality& quality, std::uint64_t seed,
                                     ThreadPool& pool) const {
  check_camera(camera);
  check_quality(quality);
  EARPOINT_CHECK(region.x >= 0 && region.width > 0 && region.x + region.width <= camera.width);
  EARPOINT_CHECK(region.y >= 0 && region.height > 0 && region.y + region.height <= camera.height);
  const LitScene lit = lit_scene();
  const ViewSampler sampler(lit, solved, camera, region, quality.samples_per_side, seed);
  TracedView traced;
  traced.view.depth_m = FloatImage(region.width, region.height, 1);
  traced.view.instance = Raster<std::int32_t>(region.width, region.height, 1);
  traced.buffers = sampler.make_buffers();
  pool.run(sampler.tiles(), [&](std::ptrdiff_t tile, int) {
    sampler.trace_middles(static_cast<int>(tile), traced.buffers, traced.view);
    sampler.trace_light(static_cast<int>(tile), traced.buffers);
  });
  if (quality.denoise) {
    traced.light = smooth_light(traced.buffers, pool);
    borrow_light(traced.light, traced.buffers, pool);
  } else {
    traced.light = mean_light(traced.buffers);
  }
  return traced;
}

SceneDrawer::SceneDrawer(const Scene& scene, const Lighting& lighting) {
  ThreadPool pool(1);
  parts_ = std::make_unique<const Parts>(scene, lighting, pool);
}

SceneDrawer::SceneDrawer(const Scene& scene, const Lighting& lighting, ThreadPool& pool)
    : parts_(std::make_unique<const Parts>(scene, lighting, pool)) {}

SceneDrawer::SceneDrawer(std::unique_ptr<const Parts> parts) : parts_(std::move(parts)) {}

SceneDrawer SceneDrawer::extended(const Scene& scene) const {
  ThreadPool pool(1);
  return extended(scene, pool);
}

SceneDrawer SceneDrawer::extended(const Scene& scene, ThreadPool& pool) const {
  return SceneDrawer(std::make_unique<const Parts>(*parts_, scene, pool));
}

SceneDrawer::~SceneDrawer() = default;
SceneDrawer::SceneDrawer(SceneDrawer&&) noexcept = default;
SceneDrawer& SceneDrawer::operator=(SceneDrawer&&) noexcept = default;

View SceneDrawer::draw(const Camera& camera, const RenderQuality& quality,
                       std::uint64_t seed) const {
  ThreadPool pool(1);
  return draw(camera, quality, seed, pool);
}

View SceneDrawer::draw(const Camera& camera, const RenderQuality& quality, std::uint64_t seed,
                       ThreadPool& pool) const {
  TracedView traced = parts_->trace(camera, whole_picture(camera), quality, seed, pool);
  const float exposure =
      quality.exposure * find_exposure(put_together(traced.buffers, traced.light));
  traced.view.rgb = develop(traced.buffers, traced.light, exposure, pool);
  return std::move(traced.view);
}

float SceneDrawer::found_exposure(const Camera& camera, const RenderQuality& quality,
                                  std::uint64_t seed, ThreadPool& pool) const {
  return find_exposure(radiance(camera, quality, seed, pool));
}

View SceneDrawer::draw_region(const Camera& camera, const PixelRegion& region,
                              const RenderQuality& quality, float exposure, std::uint64_t seed,
                              ThreadPool& pool) const {
  EARPOINT_CHECK(exposure > 0.0F);
  TracedView traced = parts_->trace(camera, region, quality, seed, pool);
  traced.view.rgb = develop(traced.buffers, traced.light, quality.exposure * exposure, pool);
  return std::move(traced.view);
}

FloatImage SceneDrawer::radiance(const Camera& camera, const RenderQuality& quality,
                                 std::uint64_t seed, ThreadPool& pool) const {
  const TracedView traced = parts_->trace(camera, whole_picture(camera), quality, seed, pool);
  return put_together(traced.buffers, traced.light);
}

std::size_t SceneDrawer::patches() const { return parts_->patches.size(); }

}  // namespace earpoint

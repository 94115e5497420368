#include "ray_tracer.h"

#include "sampling.h"

#include <limits>

#include <earpoint/core/error.h>
#include <earpoint/scene/embree_config.h>

namespace earpoint {
namespace {

constexpr unsigned kNothing = RTC_INVALID_GEOMETRY_ID;

}  // namespace

// Embree hands its context through to the filter: ours starts with Embree's.
struct RayTracer::Context {
  RTCIntersectContext embree;
  std::uint32_t seed = 0;
  SeeThrough see_through = SeeThrough::by_chance;
  std::uint32_t per_pixel = 1;

  // Whether a ray passes a surface: hangs on the two alone, not on the order of traversal.
  [[nodiscard]] bool lets_pass(std::uint32_t ray, const Geometry& geometry, unsigned number) const {
    const float opacity = geometry.opacity[number];
    switch (see_through) {
      case SeeThrough::if_mostly_so:
        return opacity < 0.5F;
      case SeeThrough::by_turns: {
        const std::uint32_t turn = (ray + geometry.material[number]) % per_pixel;
        return (static_cast<float>(turn) + 0.5F) / static_cast<float>(per_pixel) >= opacity;
      }
      case SeeThrough::by_chance:
        break;
    }
    const std::uint32_t ray_seed = hash_words(seed, ray);
    return unit_from_bits(hash_words(ray_seed, geometry.triangles[number])) >= opacity;
  }
};

void RayPacket::clear() {
  valid_.fill(0);
  // Lanes without a ray are read by the tracer, but change nothing.
  rays_ = {};
}

void RayPacket::set(int lane, const Float3& start, const Float3& direction, float length_m,
                    std::uint32_t ray_id) {
  RTCRay16& ray = rays_.ray;
  ray.org_x[lane] = start.x;
  ray.org_y[lane] = start.y;
  ray.org_z[lane] = start.z;
  ray.dir_x[lane] = direction.x;
  ray.dir_y[lane] = direction.y;
  ray.dir_z[lane] = direction.z;
  ray.tnear[lane] = 0.0F;
  ray.tfar[lane] = length_m;
  ray.time[lane] = 0.0F;
  ray.mask[lane] = ~0U;
  ray.id[lane] = ray_id;
  ray.flags[lane] = 0;
  rays_.hit.geomID[lane] = kNothing;
  rays_.hit.instID[0][lane] = kNothing;
  valid_[lane] = -1;
}

RayTracer::RayTracer(const Surfaces& surfaces) : positions_(surfaces.positions()) {
  // Embree reads 16 bytes from the last vertex on.
  positions_.emplace_back();
  for (std::uint32_t i = 0; i < surfaces.triangles(); ++i) {
    const float opacity = surfaces.material(i).opacity;
    if (opacity >= 1.0F) {
      solid_.triangles.push_back(i);
    } else {
      see_through_.triangles.push_back(i);
      see_through_.opacity.push_back(opacity);
      see_through_.material.push_back(surfaces.material_index(i));
    }
  }
  device_ = rtcNewDevice(embree_config());
  EARPOINT_CHECK(device_ != nullptr);
  scene_ = rtcNewScene(device_);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
  add_geometry(surfaces, solid_);
  add_geometry(surfaces, see_through_);
  rtcCommitScene(scene_);
  EARPOINT_CHECK(rtcGetDeviceError(device_) == RTC_ERROR_NONE);
}

RayTracer::~RayTracer() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

void RayTracer::add_geometry(const Surfaces& surfaces, Geometry& geometry) {
  // Embree's numbers are 0 and 1 whether or not there is anything to attach.
  const unsigned number = &geometry == &solid_ ? 0 : 1;
  if (geometry.triangles.empty()) return;
  RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions_.data(),
                             0, sizeof(Float3), positions_.size() - 1);
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), geometry.triangles.size()));
  EARPOINT_CHECK(indices != nullptr);
  for (const std::uint32_t triangle : geometry.triangles) {
    for (const std::uint32_t vertex : surfaces.corners(triangle)) *indices++ = vertex;
  }
  if (!geometry.opacity.empty()) {
    rtcSetGeometryUserData(mesh, &geometry);
    rtcSetGeometryIntersectFilterFunction(mesh, &RayTracer::filter);
    rtcSetGeometryOccludedFilterFunction(mesh, &RayTracer::filter);
  }
  rtcCommitGeometry(mesh);
  rtcAttachGeometryByID(scene_, mesh, number);
  rtcReleaseGeometry(mesh);
}

void RayTracer::filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& geometry = *static_cast<const Geometry*>(arguments->geometryUserPtr);
  const auto& context = *reinterpret_cast<const Context*>(arguments->context);
  const unsigned rays = arguments->N;
  for (unsigned lane = 0; lane < rays; ++lane) {
    if (arguments->valid[lane] != -1) continue;
    const unsigned number = RTCHitN_primID(arguments->hit, rays, lane);
    const std::uint32_t ray = RTCRayN_id(arguments->ray, rays, lane);
    if (context.lets_pass(ray, geometry, number)) arguments->valid[lane] = 0;
  }
}

void RayTracer::trace(RayPacket& packet, Rays rays, SeeThrough see_through, std::uint32_t seed,
                      std::uint32_t per_pixel) const {
  Context context;
  rtcInitIntersectContext(&context.embree);
  context.embree.flags = rays == Rays::alike ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                             : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  context.seed = seed;
  context.see_through = see_through;
  context.per_pixel = per_pixel;
  rtcIntersect16(packet.valid_.data(), scene_, &context.embree, &packet.rays_);
}

std::array<bool, RayPacket::kRays> RayTracer::reaches_end(RayPacket& packet,
                                                          std::uint32_t seed) const {
  Context context;
  rtcInitIntersectContext(&context.embree);
  context.seed = seed;
  rtcOccluded16(packet.valid_.data(), scene_, &context.embree, &packet.rays_.ray);
  std::array<bool, RayPacket::kRays> reached{};
  for (int lane = 0; lane < RayPacket::kRays; ++lane) {
    // Embree marks a ray that met something by a length of minus infinity.
    reached[lane] = packet.valid_[lane] != 0 && packet.rays_.ray.tfar[lane] >= 0.0F;
  }
  return reached;
}

}  // namespace earpoint

#include "ray_tracer.h"

#include "sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <earpoint/error.h>
#include <earpoint/scene/embree_config.h>

namespace earpoint {
namespace {

constexpr unsigned kNothing = RTC_INVALID_GEOMETRY_ID;

Vector3 wide(const Float3& a) { return {a.x, a.y, a.z}; }

}  // namespace

// Embree hands its context through to the filter: ours starts with Embree's.
struct RayTracer::Context {
  RTCIntersectContext embree;
  std::uint32_t seed = 0;
  SeeThrough see_through = SeeThrough::by_chance;
  std::uint32_t per_pixel = 1;

  // Whether a ray passes a surface depends only on these two, not on the order of traversal.
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
  // The tracer reads lanes without a ray; they must hold valid numbers.
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
  corners_.reserve(surfaces.triangles());
  for (std::uint32_t i = 0; i < surfaces.triangles(); ++i) {
    corners_.push_back(surfaces.corners(i));
    const float opacity = surfaces.material(i).opacity;
    if (opacity >= 1.0F) {
      solid_.triangles.push_back(i);
      is_solid_.push_back(1);
    } else {
      is_solid_.push_back(0);
      see_through_.triangles.push_back(i);
      see_through_.opacity.push_back(opacity);
      see_through_.material.push_back(surfaces.material_index(i));
    }
  }
  std::vector<std::array<float, 3>> positions;
  positions.reserve(surfaces.positions().size());
  for (const Float3& p : surfaces.positions()) positions.push_back({p.x, p.y, p.z});
  coincident_ = CoincidentFaces(positions, corners_);
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

/// Which triangle the ray meets, and where in it, by arithmetic that is the same on every
/// processor: Embree divides by approximate reciprocals, whose last bits differ between makers.
/// Source: Moeller and Trumbore, Journal of Graphics Tools 2 (1997).
void RayTracer::locate(const RTCRay16& ray, int lane, Hit& hit) const {
  const std::array<float, 3> origin = {ray.org_x[lane], ray.org_y[lane], ray.org_z[lane]};
  const std::array<float, 3> direction = {ray.dir_x[lane], ray.dir_y[lane], ray.dir_z[lane]};
  // A see-through triangle is not tested again: a coincident solid one takes precedence.
  hit.triangle = coincident_.on_top(hit.triangle, origin, direction,
                                    [&](std::uint32_t other) { return is_solid_[other] != 0; });
  const auto [a, b, c] = corners_[hit.triangle];
  const Vector3 corner = wide(positions_[a]);
  const Vector3 along_u = wide(positions_[b]) - corner;
  const Vector3 along_v = wide(positions_[c]) - corner;
  const Vector3 from_corner = Vector3{origin[0], origin[1], origin[2]} - corner;
  const Vector3 along_ray{direction[0], direction[1], direction[2]};
  const Vector3 across = cross(along_ray, along_v);
  const double slope = dot(along_u, across);
  // A ray through an edge hits one of its triangles, by rounding perhaps just beside it. A ray
  // along the plane hits the triangle anywhere.
  const auto share = [&](double numerator, double most) {
    const double part = numerator / slope;
    return std::isfinite(part) ? std::clamp(part, 0.0, most) : 0.0;
  };
  const double u = share(dot(from_corner, across), 1.0);
  const double v = share(dot(along_ray, cross(from_corner, along_u)), 1.0 - u);
  const double along = dot(u * along_u + v * along_v - from_corner, along_ray);
  hit.u = static_cast<float>(u);
  hit.v = static_cast<float>(v);
  hit.distance_m = static_cast<float>(std::max(0.0, along / dot(along_ray, along_ray)));
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

#include "triangle_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include <fmt/core.h>

#include <earpoint/error.h>
#include <earpoint/scene/embree_config.h>

namespace earpoint {
namespace {

void fail_on_error(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) {
    throw std::runtime_error(fmt::format("Embree: error {}", static_cast<int>(error)));
  }
}

RTCRay make_ray(const Vector3& origin, const Vector3& direction, double far_m, LayerMask mask) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin.x);
  ray.org_y = static_cast<float>(origin.y);
  ray.org_z = static_cast<float>(origin.z);
  ray.dir_x = static_cast<float>(direction.x);
  ray.dir_y = static_cast<float>(direction.y);
  ray.dir_z = static_cast<float>(direction.z);
  ray.tfar = static_cast<float>(far_m);
  ray.mask = mask;
  return ray;
}

}  // namespace

void SoundRayPacket::set(int lane, const std::array<float, 3>& origin,
                         const std::array<float, 3>& direction, float far_m, LayerMask mask) {
  valid[lane] = -1;
  RTCRay16& ray = rays.ray;
  ray.org_x[lane] = origin[0];
  ray.org_y[lane] = origin[1];
  ray.org_z[lane] = origin[2];
  ray.tnear[lane] = 0.0F;
  ray.dir_x[lane] = direction[0];
  ray.dir_y[lane] = direction[1];
  ray.dir_z[lane] = direction[2];
  ray.time[lane] = 0.0F;
  ray.tfar[lane] = far_m;
  ray.mask[lane] = mask;
  ray.id[lane] = 0;
  ray.flags[lane] = 0;
  rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
}

TriangleTree::TriangleTree(const Mesh& mesh, std::span<const LayerMask> layers)
    : planes_(mesh),
      coincident_(mesh.positions, mesh.triangles),
      layers_(layers.begin(), layers.end()) {
  EARPOINT_CHECK(layers.size() == mesh.triangles.size());
  original_.resize(mesh.triangles.size());
  std::iota(original_.begin(), original_.end(), 0U);
  std::stable_sort(original_.begin(), original_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return layers[a] < layers[b]; });

  device_.reset(rtcNewDevice(embree_config()));
  if (device_ == nullptr) throw std::runtime_error("Embree: no device");
  if (rtcGetDeviceProperty(device_.get(), RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) == 0) {
    throw std::runtime_error("Embree: built without ray masks");
  }
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);

  constexpr std::size_t kStride = 3 * sizeof(float);
  // Embree reads whole vectors: up to 16 bytes from the last position's start.
  const Owned<RTCBuffer> positions(
      rtcNewBuffer(device_.get(), mesh.positions.size() * kStride + sizeof(float)));
  fail_on_error(device_.get());
  auto* out = static_cast<float*>(rtcGetBufferData(positions.get()));
  for (const auto& position : mesh.positions) {
    out = std::copy(position.begin(), position.end(), out);
  }
  for (std::size_t begin = 0; begin < original_.size();) {
    const LayerMask layer = layers[original_[begin]];
    std::size_t end = begin;
    while (end < original_.size() && layers[original_[end]] == layer) ++end;
    attach(positions.get(), mesh, begin, end, layer);
    begin = end;
  }
  rtcCommitScene(scene_.get());
  fail_on_error(device_.get());
}

void TriangleTree::attach(RTCBuffer positions, const Mesh& mesh, std::size_t begin, std::size_t end,
                          LayerMask layer) {
  const Owned<RTCGeometry> geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcSetGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0,
                       3 * sizeof(float), mesh.positions.size());
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), end - begin));
  fail_on_error(device_.get());
  for (std::size_t i = begin; i < end; ++i) {
    const auto& triangle = mesh.triangles[original_[i]];
    indices = std::copy(triangle.begin(), triangle.end(), indices);
  }
  rtcSetGeometryMask(geometry.get(), layer);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene_.get(), geometry.get(), static_cast<unsigned>(first_.size()));
  first_.push_back(static_cast<std::uint32_t>(begin));
}

std::optional<TriangleHit> TriangleTree::closest(const Vector3& origin, const Vector3& direction,
                                                 double far_m, LayerMask mask) const {
  RTCRayHit ray{};
  ray.ray = make_ray(origin, direction, far_m, mask);
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene_.get(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return exact_hit(original_[first_[ray.hit.geomID] + ray.hit.primID],
                   {ray.ray.org_x, ray.ray.org_y, ray.ray.org_z},
                   {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z}, mask);
}

TriangleHit TriangleTree::exact_hit(std::uint32_t found, const std::array<float, 3>& origin,
                                    const std::array<float, 3>& direction, LayerMask mask) const {
  const auto is_seen = [&](std::uint32_t triangle) { return (layers_[triangle] & mask) != 0; };
  const std::uint32_t triangle = coincident_.on_top(found, origin, direction, is_seen);
  return {planes_.distance(triangle, origin, direction), triangle};
}

bool TriangleTree::occluded(const Vector3& from, const Vector3& to, LayerMask mask) const {
  // The direction keeps its length, so that 1 is the far end.
  RTCRay ray = make_ray(from, to - from, 1.0, mask);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene_.get(), &context, &ray);
  return ray.tfar < 0.0F;
}

void TriangleTree::closest(SoundRayPacket& packet) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect16(packet.valid, scene_.get(), &context, &packet.rays);
  RTCRay16& ray = packet.rays.ray;
  for (int i = 0; i < kPacketSize; ++i) {
    if (packet.valid[i] == 0 || !packet.hit(i)) continue;
    const TriangleHit hit =
        exact_hit(original_[first_[packet.rays.hit.geomID[i]] + packet.rays.hit.primID[i]],
                  {ray.org_x[i], ray.org_y[i], ray.org_z[i]},
                  {ray.dir_x[i], ray.dir_y[i], ray.dir_z[i]}, ray.mask[i]);
    packet.triangles[i] = hit.triangle;
    ray.tfar[i] = hit.distance_m;
  }
}

std::uint32_t TriangleTree::occluded(SoundRayPacket& packet) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded16(packet.valid, scene_.get(), &context, &packet.rays.ray);
  std::uint32_t hits = 0;
  for (int lane = 0; lane < kPacketSize; ++lane) {
    if (packet.valid[lane] != 0 && packet.rays.ray.tfar[lane] < 0.0F) hits |= 1U << lane;
  }
  return hits;
}

}  // namespace earpoint

#include <earpoint/scene/ray_caster.h>

#include <cstring>
#include <limits>

#include <embree3/rtcore.h>

#include <earpoint/error.h>
#include <earpoint/scene/embree_config.h>
#include <earpoint/scene/triangle_planes.h>

namespace earpoint {

struct RayCaster::Embree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  TrianglePlanes planes;
};

RayCaster::RayCaster(const Mesh& mesh) : embree_(std::make_unique<Embree>()) {
  embree_->device = rtcNewDevice(embree_config());
  EARPOINT_CHECK(embree_->device != nullptr);
  embree_->scene = rtcNewScene(embree_->device);
  // Robust: no ray slips through an edge that two faces share.
  rtcSetSceneFlags(embree_->scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(mesh.positions[0]), mesh.positions.size());
  std::memcpy(vertices, mesh.positions.data(), mesh.positions.size() * sizeof(mesh.positions[0]));
  void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          sizeof(mesh.triangles[0]), mesh.triangles.size());
  std::memcpy(indices, mesh.triangles.data(), mesh.triangles.size() * sizeof(mesh.triangles[0]));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(embree_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(embree_->scene);
  embree_->planes = TrianglePlanes(mesh);
}

RayCaster::~RayCaster() {
  rtcReleaseScene(embree_->scene);
  rtcReleaseDevice(embree_->device);
}

std::optional<double> RayCaster::distance_m(const Vector3& origin, const Vector3& direction,
                                            double near_m) const {
  RTCRayHit hit{};
  hit.ray.org_x = static_cast<float>(origin.x);
  hit.ray.org_y = static_cast<float>(origin.y);
  hit.ray.org_z = static_cast<float>(origin.z);
  hit.ray.dir_x = static_cast<float>(direction.x);
  hit.ray.dir_y = static_cast<float>(direction.y);
  hit.ray.dir_z = static_cast<float>(direction.z);
  hit.ray.tnear = static_cast<float>(near_m);
  hit.ray.tfar = std::numeric_limits<float>::infinity();
  hit.ray.mask = 0xFFFFFFFFU;
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(embree_->scene, &context, &hit);
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return embree_->planes.distance(hit.hit.primID, {hit.ray.org_x, hit.ray.org_y, hit.ray.org_z},
                                  {hit.ray.dir_x, hit.ray.dir_y, hit.ray.dir_z});
}

}  // namespace earpoint

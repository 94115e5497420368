#include "bare_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <vector>

#include <embree3/rtcore.h>

#include <earpoint/core/random.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kPacket = 16;
constexpr int kRays = 20000 * kPacket;
constexpr int kWalk = 60;  // rays of one walk
constexpr int kRuns = 5;   // the fastest counts

struct BareRay {
  std::array<float, 3> origin{};
  std::array<float, 3> direction{};
};

class BareScene {
 public:
  explicit BareScene(const Mesh& mesh)
      : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* positions = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.positions.size()));
    for (const auto& position : mesh.positions) {
      positions = std::copy(position.begin(), position.end(), positions);
    }
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), mesh.triangles.size()));
    for (const auto& triangle : mesh.triangles) {
      indices = std::copy(triangle.begin(), triangle.end(), indices);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    EARPOINT_CHECK(rtcGetDeviceError(device_) == RTC_ERROR_NONE);
  }
  ~BareScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  BareScene(const BareScene&) = delete;
  BareScene& operator=(const BareScene&) = delete;

  [[nodiscard]] RTCRayHit trace(const BareRay& ray) const {
    RTCRayHit hit{};
    hit.ray.org_x = ray.origin[0];
    hit.ray.org_y = ray.origin[1];
    hit.ray.org_z = ray.origin[2];
    hit.ray.dir_x = ray.direction[0];
    hit.ray.dir_y = ray.direction[1];
    hit.ray.dir_z = ray.direction[2];
    hit.ray.tfar = 1e30F;
    hit.ray.mask = ~0U;
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &hit);
    return hit;
  }

  // @return how many of 16 rays hit
  [[nodiscard]] int trace(const BareRay* rays) const {
    alignas(64) int valid[kPacket];
    RTCRayHit16 hit{};
    for (int i = 0; i < kPacket; ++i) {
      valid[i] = -1;
      hit.ray.org_x[i] = rays[i].origin[0];
      hit.ray.org_y[i] = rays[i].origin[1];
      hit.ray.org_z[i] = rays[i].origin[2];
      hit.ray.dir_x[i] = rays[i].direction[0];
      hit.ray.dir_y[i] = rays[i].direction[1];
      hit.ray.dir_z[i] = rays[i].direction[2];
      hit.ray.tfar[i] = 1e30F;
      hit.ray.mask[i] = ~0U;
      hit.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect16(valid, scene_, &context, &hit);
    int hits = 0;
    for (const unsigned id : hit.hit.geomID) hits += id != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
    return hits;
  }

 private:
  RTCDevice device_;
  RTCScene scene_;
};

std::array<float, 3> random_direction(RandomStream& random) {
  const double z = random.uniform(-1.0, 1.0);
  const double azimuth_rad = random.uniform(0.0, 6.283185307179586);
  const double across = std::sqrt(1.0 - z * z);
  return {static_cast<float>(across * std::cos(azimuth_rad)),
          static_cast<float>(across * std::sin(azimuth_rad)), static_cast<float>(z)};
}

// The walks take turns, as in the tracer, so that consecutive rays are not coherent.
std::vector<BareRay> make_rays(const BareScene& scene, const Vector3& inside) {
  RandomStream random(5);
  const BareRay start{
      {static_cast<float>(inside.x), static_cast<float>(inside.y), static_cast<float>(inside.z)},
      {}};
  constexpr int kWalks = kRays / kWalk;
  std::vector<BareRay> walks(kWalks, start);
  for (BareRay& ray : walks) ray.direction = random_direction(random);
  std::vector<BareRay> rays;
  while (rays.size() < kRays) {
    for (BareRay& ray : walks) {
      if (rays.size() < kRays) rays.push_back(ray);
      const RTCRayHit hit = scene.trace(ray);
      if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
        ray = start;
        ray.direction = random_direction(random);
        continue;
      }
      std::array<float, 3> normal = {hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z};
      const float length = std::hypot(normal[0], normal[1], normal[2]);
      float towards = 0.0F;
      for (int axis = 0; axis < 3; ++axis) towards += normal[axis] * ray.direction[axis];
      const float scale = (towards < 0.0F ? 1.0F : -1.0F) / length;
      const std::array<float, 3> point = random_direction(random);
      for (int axis = 0; axis < 3; ++axis) {
        normal[axis] *= scale;
        ray.origin[axis] += hit.ray.tfar * ray.direction[axis] + 1e-4F * normal[axis];
        ray.direction[axis] = normal[axis] + 0.999F * point[axis];
      }
    }
  }
  return rays;
}

double now_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

double bare_rays_per_s(const Mesh& mesh, const Vector3& inside) {
  const BareScene scene(mesh);
  const std::vector<BareRay> rays = make_rays(scene, inside);
  double fastest_s = 1e30;
  for (int run = 0; run < kRuns; ++run) {
    int hits = 0;
    double start = now_s();
    for (const BareRay& ray : rays) {
      hits += scene.trace(ray).hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
    }
    fastest_s = std::min(fastest_s, now_s() - start);
    int packet_hits = 0;
    start = now_s();
    for (std::size_t i = 0; i < rays.size(); i += kPacket) packet_hits += scene.trace(&rays[i]);
    fastest_s = std::min(fastest_s, now_s() - start);
    EARPOINT_CHECK(hits == packet_hits);
  }
  return static_cast<double>(rays.size()) / fastest_s;
}

}  // namespace earpoint

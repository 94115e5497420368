#pragma once

#include "float3.h"
#include "surfaces.h"

#include <array>
#include <cstdint>
#include <vector>

#include <embree3/rtcore.h>

#include <earpoint/scene/coincident_faces.h>

namespace earpoint {

/// What a ray meets first.
struct Hit {
  float distance_m = 0.0F;
  std::uint32_t triangle = 0;
  float u = 0.0F;
  float v = 0.0F;
};

/// Sixteen rays that are traced together.
class RayPacket {
 public:
  static constexpr int kRays = 16;

  RayPacket() { clear(); }

  /// Leaves no ray in it.
  void clear();

  /// @param ray_id  decides, with the seed, which see-through surfaces let this ray pass
  void set(int lane, const Float3& start, const Float3& direction, float length_m,
           std::uint32_t ray_id);

  [[nodiscard]] bool active(int lane) const { return valid_[lane] != 0; }

 private:
  friend class RayTracer;
  RTCRayHit16 rays_;
  alignas(64) std::array<int, kRays> valid_;
};

/// Which ray passes which see-through surface.
enum class SeeThrough {
  by_chance,    ///< each surface stops its opacity's share of the rays
  by_turns,     ///< each material stops the same rays of every pixel, as near to its opacity's
                ///< share as their number allows: free of noise; a pane's two faces count once
  if_mostly_so  ///< surfaces with an opacity below a half stop none, all others stop every ray
};

/// Finds what rays meet. Watertight at the edges between triangles.
class RayTracer {
 public:
  explicit RayTracer(const Surfaces& surfaces);
  ~RayTracer();
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  /// How alike the rays of a packet are: a hint for speed.
  enum class Rays { alike, mixed };

  /// After this, hit() gives what each ray of the packet hits.
  /// @param per_pixel  for `by_turns`: so many rays whose numbers follow each other, beginning with
  ///                   a multiple of it, belong to one pixel; > 0
  void trace(RayPacket& packet, Rays rays, SeeThrough see_through, std::uint32_t seed,
             std::uint32_t per_pixel = 1) const;

  /// @return false if the lane holds no ray or its ray meets nothing
  bool hit(const RayPacket& packet, int lane, Hit& hit) const {
    const RTCHit16& found = packet.rays_.hit;
    const unsigned geometry = found.geomID[lane];
    if (packet.valid_[lane] == 0 || geometry == RTC_INVALID_GEOMETRY_ID) return false;
    const Geometry& from = geometry == 0 ? solid_ : see_through_;
    hit = {packet.rays_.ray.tfar[lane], from.triangles[found.primID[lane]], found.u[lane],
           found.v[lane]};
    locate(packet.rays_.ray, lane, hit);
    return true;
  }

  /// Whether each ray of the packet reaches its end; false for lanes without a ray.
  [[nodiscard]] std::array<bool, RayPacket::kRays> reaches_end(RayPacket& packet,
                                                               std::uint32_t seed) const;

 private:
  struct Geometry {
    RayTracer* tracer = nullptr;
    std::vector<std::uint32_t> triangles;  // numbers in the scene, by Embree's number
    std::vector<float> opacity;            // empty when all are opaque
    std::vector<std::uint32_t> material;   // likewise
  };
  struct Context;

  void add_geometry(const Surfaces& surfaces, Geometry& geometry);
  void locate(const RTCRay16& ray, int lane, Hit& hit) const;
  static void filter(const RTCFilterFunctionNArguments* arguments);

  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::vector<Float3> positions_;  // padded for Embree
  std::vector<std::array<std::uint32_t, 3>> corners_;
  CoincidentFaces coincident_;
  std::vector<std::uint8_t> is_solid_;  // [triangles]
  Geometry solid_;
  Geometry see_through_;
};

}  // namespace earpoint

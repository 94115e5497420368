#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <embree3/rtcore.h>

#include <earpoint/scene/coincident_faces.h>
#include <earpoint/scene/mesh.h>
#include <earpoint/scene/triangle_planes.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// Which triangles a ray sees: a set of bits, matched against each triangle's layer.
using LayerMask = std::uint32_t;

constexpr LayerMask kOpaqueLayer = 1U;        ///< walls and furniture
constexpr LayerMask kTransmissiveLayer = 2U;  ///< lets some sound through
constexpr LayerMask kAllLayers = ~0U;
/// Each person has a layer, as far as there are bits; further people share the last one.
constexpr int kPersonLayers = 30;
constexpr LayerMask person_layer(int person) {
  return 4U << (person < kPersonLayers ? person : kPersonLayers - 1);
}

/// Where a ray first meets the mesh.
struct TriangleHit {
  float distance_m = 0.0F;
  std::uint32_t triangle = 0;  ///< index into the mesh
};

/// How many rays travel together.
constexpr int kPacketSize = 16;

/// A packet of rays, one array per field. Fields of lanes that are not valid are ignored.
struct SoundRayPacket {
  alignas(64) int valid[kPacketSize] = {};  ///< -1 valid, 0 not
  RTCRayHit16 rays{};
  std::array<std::uint32_t, kPacketSize> triangles{};  ///< of the mesh, for the lanes that hit

  void set(int lane, const std::array<float, 3>& origin, const std::array<float, 3>& direction,
           float far_m, LayerMask mask);
  [[nodiscard]] bool hit(int lane) const {
    return rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
  }
};

/// Rays against triangles: a thin layer over Embree in robust mode. Watertight: a ray does not slip
/// through an edge that two triangles share. Distances are those to the triangles' planes, and of
/// triangles that lie on each other one counts, the same on every processor with the instructions
/// of embree_config(). Const calls may be made from many threads at once.
class TriangleTree {
 public:
  /// @param layers  [triangles], one bit per triangle
  /// @throws std::runtime_error if Embree cannot build its tree
  TriangleTree(const Mesh& mesh, std::span<const LayerMask> layers);

  /// @param direction  unit length
  [[nodiscard]] std::optional<TriangleHit> closest(const Vector3& origin, const Vector3& direction,
                                                   double far_m, LayerMask mask) const;

  /// @return whether a triangle lies between the two points
  [[nodiscard]] bool occluded(const Vector3& from, const Vector3& to, LayerMask mask) const;

  /// Fills in the hits of all valid lanes.
  void closest(SoundRayPacket& packet) const;

  /// @return by lane (bit), whether the valid rays hit something
  [[nodiscard]] std::uint32_t occluded(SoundRayPacket& packet) const;

 private:
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    void operator()(RTCBuffer buffer) const { rtcReleaseBuffer(buffer); }
    void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
  };
  template <typename Handle>
  using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release>;

  void attach(RTCBuffer positions, const Mesh& mesh, std::size_t begin, std::size_t end,
              LayerMask layer);
  [[nodiscard]] TriangleHit exact_hit(std::uint32_t found, const std::array<float, 3>& origin,
                                      const std::array<float, 3>& direction, LayerMask mask) const;

  TrianglePlanes planes_;
  CoincidentFaces coincident_;
  std::vector<LayerMask> layers_;  // [triangles]
  Owned<RTCDevice> device_;
  Owned<RTCScene> scene_;
  std::vector<std::uint32_t> original_;  // triangles sorted by layer -> the mesh's
  std::vector<std::uint32_t> first_;     // [geometry]: where its triangles start in original_
};

}  // namespace earpoint

#pragma once

#include <memory>
#include <optional>

#include <earpoint/scene/mesh.h>

namespace earpoint {

/// Finds where rays first meet a mesh. The mesh must outlive it and stay as it is.
class RayCaster {
 public:
  explicit RayCaster(const Mesh& mesh);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  /// @param direction  a unit vector
  /// @param near_m     hits closer than this are skipped
  /// @return the distance of the first face in metres; nothing if the ray escapes
  [[nodiscard]] std::optional<double> distance_m(const Vector3& origin, const Vector3& direction,
                                                 double near_m = 0.0) const;

 private:
  struct Embree;
  std::unique_ptr<Embree> embree_;
};

}  // namespace earpoint

#pragma once

#include <memory>

#include <earpoint/scene/scene.h>

namespace earpoint {

class SceneGeometry;  // the tracer's own view of the triangles

/// A scene made ready for tracing: the tree of its triangles, its surfaces, its edges.
/// Immutable; may be used by many threads at once.
class AcousticScene {
 public:
  /// @param scene  as `check_scene` leaves it; not needed afterwards
  /// @throws std::logic_error if an index points nowhere
  explicit AcousticScene(const Scene& scene);
  ~AcousticScene();
  AcousticScene(AcousticScene&&) noexcept;
  AcousticScene& operator=(AcousticScene&&) noexcept;

  [[nodiscard]] const SceneGeometry& geometry() const { return *geometry_; }

 private:
  std::unique_ptr<const SceneGeometry> geometry_;
};

}  // namespace earpoint

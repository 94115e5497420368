#pragma once

#include <earpoint/scene/furniture.h>

namespace earpoint {

/// The range of sizes in which a kind is built: depth (x), width (y), height (z).
struct SizeRange {
  Vector3 low_m;
  Vector3 high_m;
};

SizeRange stand_in_sizes(FurnitureKind kind);

/// Adds the boxes, cylinders and sheets of a stand-in to the instance that was begun: within
/// `size_m`, front along x, standing on z = 0, its middle at the origin.
void add_stand_in(FurnitureKind kind, const Vector3& size_m, const FurnitureStyle& style,
                  SceneBuilder& builder);

}  // namespace earpoint

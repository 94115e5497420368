#pragma once

#include "sampling.h"
#include "surfaces.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/scene/scene.h>

namespace earpoint {

/// A direction towards a light, drawn at random.
struct LightSample {
  Float3 direction;         ///< unit length
  float distance_m = 0.0F;  ///< free up to here: the light is seen
  Rgb radiance;             ///< of the light in this direction
  float density = 0.0F;     ///< of the draw, per solid angle; 0 if nothing was drawn
};

/// What shines: lamps, which are balls that rays do not meet, and shining triangles, gathered into
/// groups that lie together. Triangles shine to both sides.
class Lights {
 public:
  Lights(const Surfaces& surfaces, std::span<const Lamp> lamps);

  /// The same lights among more surfaces, none of which shines.
  Lights(const Lights& base, const Surfaces& surfaces);

  [[nodiscard]] int size() const { return static_cast<int>(lights_.size()); }

  /// Lamps are never met by rays; their light comes by sample() alone.
  [[nodiscard]] bool is_lamp(int light) const { return light < lamps_; }

  /// @param which  uniform; chooses among the triangles of a group
  /// @param where  uniform; chooses the place
  [[nodiscard]] LightSample sample(int light, const Float3& from, float which,
                                   UnitPair where) const;

  /// The group of a triangle, -1 if it does not shine.
  [[nodiscard]] int light_of(std::uint32_t triangle) const {
    return triangle_light_.empty() ? -1 : triangle_light_[triangle];
  }

  /// The density with which sample() would have drawn a place on a shining triangle.
  /// @param cosine  between the ray and the triangle's normal, in size
  [[nodiscard]] float density(int light, float distance_m, float cosine) const;

  /// What one sees of the lamps along a ray: radiance of all that lie before `length_m`.
  [[nodiscard]] Rgb lamps_along(const Float3& start, const Float3& direction, float length_m) const;

 private:
  struct Light {
    Float3 centre;            // of a lamp
    float radius_m = 0.0F;    // of a lamp; 0 for a group
    Rgb radiance;             // of a lamp
    float area_m2 = 0.0F;     // of a group
    std::uint32_t first = 0;  // of a group: its part of members_
    std::uint32_t count = 0;
  };

  void gather_groups();
  [[nodiscard]] LightSample sample_lamp(const Light& lamp, const Float3& from,
                                        UnitPair where) const;
  [[nodiscard]] LightSample sample_group(const Light& group, const Float3& from, float which,
                                         UnitPair where) const;

  const Surfaces* surfaces_;
  std::vector<Light> lights_;
  int lamps_ = 0;                              // the first of lights_
  std::vector<std::uint32_t> members_;         // triangles, group by group
  std::vector<float> member_cumulative_area_;  // [members], within the group
  std::vector<std::int32_t> triangle_light_;   // [triangles], or empty
};

}  // namespace earpoint

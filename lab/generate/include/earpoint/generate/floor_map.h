#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/scene/ray_caster.h>
#include <earpoint/scene/scene.h>

namespace earpoint {

/// A place on the floor, metres.
struct FloorPoint {
  double x = 0.0;
  double y = 0.0;

  friend constexpr bool operator==(const FloorPoint&, const FloorPoint&) = default;
};

inline double distance_m(const FloorPoint& a, const FloorPoint& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// Where one can stand in a scene: the parts of its floor with 1.95 m of free air above them, found
/// with rays on a grid, so that procedural homes and scans are treated alike. Of several floors the
/// largest counts; pockets under 2.5 m2 (the inside of a wardrobe) do not.
class FloorMap {
 public:
  /// @param scene   as `check_scene` leaves it
  /// @param caster  of the scene's mesh; used during construction only
  FloorMap(const Scene& scene, const RayCaster& caster);

  /// @return the height of the floor; 0 if there is no place to stand
  [[nodiscard]] double floor_m() const { return floor_m_; }
  /// @return the area to stand on
  [[nodiscard]] double area_m2() const;

  /// @return how far the nearest obstacle is at least, up to about 2 m; 0 where one cannot stand
  [[nodiscard]] double clearance_m(const FloorPoint& point) const;

  /// Draws a place, evenly over the area.
  /// @return nothing if there is none with that clearance
  [[nodiscard]] std::optional<FloorPoint> draw(double clearance_m, RandomStream& random) const;

  /// The places that are near on foot: the way there, round walls and furniture, is no longer than
  /// that. In a fixed order.
  [[nodiscard]] std::vector<FloorPoint> within_walk(const FloorPoint& from, double longest_m) const;

 private:
  [[nodiscard]] std::size_t cells() const { return static_cast<std::size_t>(columns_) * rows_; }
  [[nodiscard]] std::optional<std::size_t> cell_at(const FloorPoint& point) const;
  [[nodiscard]] FloorPoint middle(std::size_t cell) const;
  void choose_bounds(const Scene& scene);
  void look_down(const RayCaster& caster, double top_m);
  void look_along(const RayCaster& caster);
  void drop_pockets();
  /// Whether a cell's neighbour (-1, 0 or 1 away along each axis) can be stepped to.
  [[nodiscard]] bool may_step(std::size_t cell, int dx, int dy) const;
  [[nodiscard]] std::vector<unsigned char> open_cells() const;
  void measure_clearance();

  double x_min_ = 0.0;
  double y_min_ = 0.0;
  double cell_m_ = 0.05;
  int columns_ = 0;
  int rows_ = 0;
  double floor_m_ = 0.0;
  std::vector<unsigned char> free_;     // [rows][columns]
  std::vector<unsigned char> wall_x_;   // [rows][columns]: between this cell and the next column
  std::vector<unsigned char> wall_y_;   // [rows][columns]: between this cell and the next row
  std::vector<float> clearance_cells_;  // [rows][columns]
};

}  // namespace earpoint

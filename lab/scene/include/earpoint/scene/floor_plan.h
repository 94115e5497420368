#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <earpoint/core/random.h>

namespace earpoint {

/// An axis-aligned rectangle on the floor, metres.
struct FloorRectangle {
  double x_min = 0.0;
  double y_min = 0.0;
  double x_max = 0.0;
  double y_max = 0.0;

  [[nodiscard]] constexpr double width_m() const { return x_max - x_min; }
  [[nodiscard]] constexpr double depth_m() const { return y_max - y_min; }
  [[nodiscard]] constexpr double area_m2() const { return width_m() * depth_m(); }
  [[nodiscard]] constexpr double centre_x() const { return (x_min + x_max) / 2.0; }
  [[nodiscard]] constexpr double centre_y() const { return (y_min + y_max) / 2.0; }
  [[nodiscard]] constexpr bool contains(double x, double y) const {
    return x >= x_min && x <= x_max && y >= y_min && y <= y_max;
  }
  friend constexpr bool operator==(const FloorRectangle&, const FloorRectangle&) = default;
};

/// @return whether the two share more than an edge
constexpr bool overlap(const FloorRectangle& a, const FloorRectangle& b) {
  return a.x_min < b.x_max && b.x_min < a.x_max && a.y_min < b.y_max && b.y_min < a.y_max;
}

/// @return `r` with every side moved outwards by `margin_m` (inwards if negative)
constexpr FloorRectangle grown(const FloorRectangle& r, double margin_m) {
  return {r.x_min - margin_m, r.y_min - margin_m, r.x_max + margin_m, r.y_max + margin_m};
}

enum class RoomKind { living_room, bedroom, kitchen, bathroom, office, corridor };

/// @return "living room", "bedroom", ...
std::string_view name_of(RoomKind kind);

struct Room {
  RoomKind kind = RoomKind::living_room;
  FloorRectangle floor;    ///< between the walls
  double ceiling_m = 2.5;  ///< above the floor
};

/// The side of a room: towards low x, high x, low y, high y.
enum class Side { x_low, x_high, y_low, y_high };

enum class DoorState {
  open,     ///< the leaf stands open in `room_a`
  closed,   ///< the leaf fills the opening
  passage,  ///< no leaf
};

/// A doorway between two rooms, or from a room to the outside.
struct Door {
  static constexpr int kOutside = -1;

  int room_a = 0;
  int room_b = kOutside;         ///< kOutside: the front door, always closed
  Side side_of_a = Side::x_low;  ///< the wall of room_a that it is in
  FloorRectangle opening;        ///< the hole in the wall, as deep as the wall is thick
  double height_m = 2.0;
  DoorState state = DoorState::open;
  bool hinge_at_high_end = false;  ///< the leaf hangs at the end of higher x or y
  double leaf_angle_rad = 0.0;     ///< 0 is closed; of an open leaf
};

/// A window in an outer wall. The pane stands at the outer end of the recess.
struct HomeWindow {
  int room = 0;
  Side side = Side::x_low;
  FloorRectangle recess;  ///< the hole in the wall, from the room to the pane
  double sill_m = 0.9;
  double head_m = 2.1;
};

/// Rooms on one floor at z = 0, apart by the thickness of their walls. All coordinates are whole
/// centimetres.
struct FloorPlan {
  std::vector<Room> rooms;
  std::vector<Door> doors;
  std::vector<HomeWindow> windows;
  double inner_wall_m = 0.12;

  /// @return the sum over the rooms' floors, corridor included
  [[nodiscard]] double area_m2() const;
  /// @return the rectangle around all rooms
  [[nodiscard]] FloorRectangle footprint() const;
};

/// @return the floor that the leaf of an open door stands on; an empty rectangle for other doors
FloorRectangle leaf_footprint(const FloorPlan& plan, const Door& door);

/// What a plan is drawn for; what is left open is drawn at random.
struct PlanOptions {
  std::optional<int> rooms{};         ///< 1 to 6, a corridor not counted
  std::optional<double> area_m2{};    ///< 20 to 150
  std::optional<double> ceiling_m{};  ///< 2.3 to 3.2
};

/// Draws a plan: rooms side by side or along a corridor, every room reachable through doors (open
/// or closed) and passages, one front door, windows in outer walls.
/// @throws InputError if an option is out of range, or the rooms do not fit the area
FloorPlan draw_floor_plan(const PlanOptions& options, RandomStream& random);

/// Fills in doors and windows of a plan whose rooms are laid out.
/// @return false if not every room can be reached
bool add_openings(FloorPlan& plan, RandomStream& random);

}  // namespace earpoint

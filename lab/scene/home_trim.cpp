#include "home_shell.h"

#include <algorithm>
#include <utility>

namespace earpoint {
namespace {

constexpr double kHeight_m = 0.08;
constexpr double kThickness_m = 0.012;
constexpr double kOffWall_m = 0.002;
/// Boards end before doorways, so that diffracting edges remain those of the wall.
constexpr double kBeforeDoor_m = 0.05;

bool faces_x(Side side) { return side == Side::x_low || side == Side::x_high; }

Side opposite(Side side) {
  switch (side) {
    case Side::x_low:
      return Side::x_high;
    case Side::x_high:
      return Side::x_low;
    case Side::y_low:
      return Side::y_high;
    case Side::y_high:
      return Side::y_low;
  }
  return Side::x_low;
}

using Span = std::pair<double, double>;

/// The doorways in one wall of a room, as spans along it, ascending.
std::vector<Span> doorways_in(const FloorPlan& plan, int room, Side side) {
  std::vector<Span> spans;
  for (const Door& door : plan.doors) {
    const bool here = (door.room_a == room && door.side_of_a == side) ||
                      (door.room_b == room && opposite(door.side_of_a) == side);
    if (!here) continue;
    const FloorRectangle& r = door.opening;
    spans.push_back(faces_x(side) ? Span{r.y_min, r.y_max} : Span{r.x_min, r.x_max});
  }
  std::sort(spans.begin(), spans.end());
  return spans;
}

void add_board(const FloorRectangle& floor, Side side, const Span& along, Surface surface,
               SceneBuilder& builder) {
  const bool high = side == Side::x_high || side == Side::y_high;
  const double wall =
      faces_x(side) ? (high ? floor.x_max : floor.x_min) : (high ? floor.y_max : floor.y_min);
  const double a = wall + (high ? -kOffWall_m : kOffWall_m);
  const double b = a + (high ? -kThickness_m : kThickness_m);
  const double low = std::min(a, b);
  const double top = std::max(a, b);
  constexpr double kAboveFloor_m = 0.001;
  if (faces_x(side)) {
    builder.add_box({low, along.first, kAboveFloor_m}, {top, along.second, kHeight_m}, surface);
  } else {
    builder.add_box({along.first, low, kAboveFloor_m}, {along.second, top, kHeight_m}, surface);
  }
}

}  // namespace

void add_skirting(const FloorPlan& plan, const HomeFinish& finish, SceneBuilder& builder) {
  builder.begin_instance("skirting", InstanceKind::structure);
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    // Baths are tiled down to the floor.
    if (plan.rooms[i].kind == RoomKind::bathroom) continue;
    const FloorRectangle& floor = plan.rooms[i].floor;
    for (const Side side : {Side::x_low, Side::x_high, Side::y_low, Side::y_high}) {
      const double corner_m = kOffWall_m + kThickness_m;
      double from = (faces_x(side) ? floor.y_min : floor.x_min) + corner_m;
      const double end = (faces_x(side) ? floor.y_max : floor.x_max) - corner_m;
      const auto board = [&](double to) {
        if (to - from > 0.05) add_board(floor, side, {from, to}, finish.frame, builder);
      };
      for (const Span& doorway : doorways_in(plan, static_cast<int>(i), side)) {
        board(doorway.first - kBeforeDoor_m);
        from = doorway.second + kBeforeDoor_m;
      }
      board(end);
    }
  }
}

}  // namespace earpoint

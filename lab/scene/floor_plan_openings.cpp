#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <earpoint/pose.h>
#include <earpoint/scene/floor_plan.h>

namespace earpoint {
namespace {

constexpr double kCornerMargin_m = 0.12;  ///< of wall beside a door or window
constexpr double kRecess_m = 0.18;        ///< from the inside of an outer wall to pane or leaf

double snapped(double metres) { return std::round(metres * 100.0) / 100.0; }

/// A straight piece of wall, seen from one room.
struct WallPiece {
  int room = 0;
  int other = Door::kOutside;
  Side side = Side::x_low;
  double low = 0.0;   ///< along the wall
  double high = 0.0;  ///< along the wall
  [[nodiscard]] double length_m() const { return high - low; }
};

bool runs_along_y(Side side) { return side == Side::x_low || side == Side::x_high; }

/// The hole in a wall of `depth_m` between two points along it.
FloorRectangle hole(const FloorRectangle& room, Side side, double low, double high,
                    double depth_m) {
  switch (side) {
    case Side::x_low:
      return {snapped(room.x_min - depth_m), low, room.x_min, high};
    case Side::x_high:
      return {room.x_max, low, snapped(room.x_max + depth_m), high};
    case Side::y_low:
      return {low, snapped(room.y_min - depth_m), high, room.y_min};
    case Side::y_high:
      return {low, room.y_max, high, snapped(room.y_max + depth_m)};
  }
  return {};
}

/// The walls between two rooms, each once, seen from the room with the lower index.
std::vector<WallPiece> shared_walls(const FloorPlan& plan) {
  std::vector<WallPiece> walls;
  const auto meets = [&](double a, double b) {
    return std::abs(b - a - plan.inner_wall_m) < 0.005;
  };
  const auto add = [&](int room, int other, Side side, double low, double high) {
    if (high > low) walls.push_back({room, other, side, low, high});
  };
  const int count = static_cast<int>(plan.rooms.size());
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < count; ++j) {
      const FloorRectangle& a = plan.rooms[static_cast<std::size_t>(i)].floor;
      const FloorRectangle& b = plan.rooms[static_cast<std::size_t>(j)].floor;
      const double x_low = std::max(a.x_min, b.x_min);
      const double x_high = std::min(a.x_max, b.x_max);
      const double y_low = std::max(a.y_min, b.y_min);
      const double y_high = std::min(a.y_max, b.y_max);
      if (meets(a.x_max, b.x_min)) add(i, j, Side::x_high, y_low, y_high);
      if (meets(b.x_max, a.x_min)) add(i, j, Side::x_low, y_low, y_high);
      if (meets(a.y_max, b.y_min)) add(i, j, Side::y_high, x_low, x_high);
      if (meets(b.y_max, a.y_min)) add(i, j, Side::y_low, x_low, x_high);
    }
  }
  return walls;
}

std::vector<WallPiece> outer_walls(const FloorPlan& plan) {
  std::vector<WallPiece> walls;
  const FloorRectangle around = plan.footprint();
  for (int i = 0; i < static_cast<int>(plan.rooms.size()); ++i) {
    const FloorRectangle& floor = plan.rooms[static_cast<std::size_t>(i)].floor;
    const auto add = [&](Side side) {
      const bool along_y = runs_along_y(side);
      walls.push_back({i, Door::kOutside, side, along_y ? floor.y_min : floor.x_min,
                       along_y ? floor.y_max : floor.x_max});
    };
    if (floor.x_min == around.x_min) add(Side::x_low);
    if (floor.x_max == around.x_max) add(Side::x_high);
    if (floor.y_min == around.y_min) add(Side::y_low);
    if (floor.y_max == around.y_max) add(Side::y_high);
  }
  return walls;
}

RoomKind kind_of(const FloorPlan& plan, int room) {
  return plan.rooms[static_cast<std::size_t>(room)].kind;
}

DoorState draw_state(const FloorPlan& plan, const WallPiece& wall, RandomStream& random) {
  const bool bath = kind_of(plan, wall.room) == RoomKind::bathroom ||
                    kind_of(plan, wall.other) == RoomKind::bathroom;
  const double draw = random.uniform();
  if (draw < (bath ? 0.55 : 0.25)) return DoorState::closed;
  return bath || draw < 0.7 ? DoorState::open : DoorState::passage;
}

/// Cuts a doorway into a wall that is long enough.
Door draw_door(const FloorPlan& plan, const WallPiece& wall, RandomStream& random) {
  Door door;
  door.room_a = wall.room;
  door.room_b = wall.other;
  door.side_of_a = wall.side;
  door.state = draw_state(plan, wall, random);
  const double longest_m = wall.length_m() - 2.0 * kCornerMargin_m;
  const bool wide = door.state == DoorState::passage && longest_m > 1.3 && random.uniform() < 0.6;
  const double width_m = snapped(wide ? random.uniform(1.2, std::min(2.0, longest_m))
                                      : random.uniform(0.75, std::min(0.95, longest_m)));
  // Doors are mostly near a corner, which leaves the rest of the wall usable.
  double start_m = wall.low + kCornerMargin_m;
  const double last_start_m = wall.high - kCornerMargin_m - width_m;
  const double draw = random.uniform();
  if (draw < 0.35) {
    start_m = last_start_m;
  } else if (draw > 0.7) {
    start_m = random.uniform(start_m, std::max(start_m, last_start_m));
  }
  start_m = snapped(std::min(start_m, last_start_m));
  door.opening = hole(plan.rooms[static_cast<std::size_t>(wall.room)].floor, wall.side, start_m,
                      snapped(start_m + width_m), plan.inner_wall_m);
  door.hinge_at_high_end = start_m - wall.low > wall.high - (start_m + width_m);
  door.leaf_angle_rad = radians_from_degrees(random.uniform(72.0, 90.0));
  const double ceiling_m = std::min(plan.rooms[static_cast<std::size_t>(wall.room)].ceiling_m,
                                    plan.rooms[static_cast<std::size_t>(wall.other)].ceiling_m);
  door.height_m = snapped(std::min(random.uniform(1.98, wide ? 2.3 : 2.1), ceiling_m - 0.15));
  return door;
}

/// Joins all rooms by the cheapest doors (Kruskal), then adds a few more.
bool add_inner_doors(FloorPlan& plan, RandomStream& random) {
  struct Candidate {
    WallPiece wall;
    double cost;
  };
  std::vector<Candidate> candidates;
  for (const WallPiece& wall : shared_walls(plan)) {
    if (wall.length_m() < 0.8 + 2.0 * kCornerMargin_m) continue;
    double cost = random.uniform();
    for (const int room : {wall.room, wall.other}) {
      const RoomKind kind = kind_of(plan, room);
      if (kind == RoomKind::corridor) cost -= 2.0;
      if (kind == RoomKind::living_room) cost -= 0.5;
      if (kind == RoomKind::bathroom) cost += 1.0;
    }
    candidates.push_back({wall, cost});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  std::vector<std::size_t> group(plan.rooms.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  std::size_t groups = group.size();
  for (const Candidate& candidate : candidates) {
    const std::size_t a = group[static_cast<std::size_t>(candidate.wall.room)];
    const std::size_t b = group[static_cast<std::size_t>(candidate.wall.other)];
    const bool bath = kind_of(plan, candidate.wall.room) == RoomKind::bathroom ||
                      kind_of(plan, candidate.wall.other) == RoomKind::bathroom;
    if (a == b && (bath || random.uniform() > 0.25)) continue;
    plan.doors.push_back(draw_door(plan, candidate.wall, random));
    if (a == b) continue;
    std::replace(group.begin(), group.end(), b, a);
    --groups;
  }
  return groups == 1;
}

/// Removes the leaf of doors that would hit another leaf or stand in another doorway.
void unhang_striking_leaves(FloorPlan& plan) {
  for (Door& door : plan.doors) {
    if (door.state != DoorState::open) continue;
    const FloorRectangle leaf = leaf_footprint(plan, door);
    const bool strikes = std::any_of(plan.doors.begin(), plan.doors.end(), [&](const Door& other) {
      if (&other == &door) return false;
      return overlap(leaf, grown(other.opening, 0.3)) ||
             overlap(grown(leaf, 0.02), leaf_footprint(plan, other));
    });
    if (strikes) door.state = DoorState::passage;
  }
}

/// @return rank of a room for the front door; 0 is best
int front_door_rank(RoomKind kind) {
  if (kind == RoomKind::corridor) return 0;
  if (kind == RoomKind::living_room) return 1;
  return kind == RoomKind::bathroom ? 3 : 2;
}

bool add_front_door(FloorPlan& plan, const std::vector<WallPiece>& walls, RandomStream& random) {
  constexpr double kWidth_m = 0.95;
  const WallPiece* best = nullptr;
  for (const WallPiece& wall : walls) {
    if (wall.length_m() < kWidth_m) continue;
    if (best == nullptr ||
        front_door_rank(kind_of(plan, wall.room)) < front_door_rank(kind_of(plan, best->room))) {
      best = &wall;
    }
  }
  if (best == nullptr) return false;
  const Room& room = plan.rooms[static_cast<std::size_t>(best->room)];
  const double slack_m = best->length_m() - kWidth_m;
  const double margin_m = std::min(kCornerMargin_m, slack_m / 2.0);
  const double start_m =
      snapped(best->low + (random.uniform() < 0.5 ? margin_m : slack_m - margin_m));
  Door door;
  door.room_a = best->room;
  door.side_of_a = best->side;
  door.opening = hole(room.floor, best->side, start_m, snapped(start_m + kWidth_m), kRecess_m);
  door.height_m = snapped(std::min(2.1, room.ceiling_m - 0.15));
  door.state = DoorState::closed;
  plan.doors.push_back(door);
  return true;
}

/// Sills are above the furniture below them: a worktop in the kitchen, a washbasin in the bath.
double draw_sill(RoomKind kind, bool french, RandomStream& random) {
  if (kind == RoomKind::bathroom) return 1.3;
  if (kind == RoomKind::kitchen) return 1.05;
  return french ? 0.08 : random.uniform(0.75, 1.0);
}

/// Adds windows along one wall, evenly spaced, except at the front door.
void add_windows_to(FloorPlan& plan, const WallPiece& wall, RandomStream& random) {
  const Room& room = plan.rooms[static_cast<std::size_t>(wall.room)];
  const bool bath = room.kind == RoomKind::bathroom;
  const bool corridor = room.kind == RoomKind::corridor;
  if (random.uniform() > (bath || corridor ? 0.4 : 0.85)) return;
  const int count = std::max(1, static_cast<int>(wall.length_m() / random.uniform(2.0, 3.2)));
  const double pitch_m = wall.length_m() / count;
  const double width_m = snapped(std::min(
      pitch_m - 0.5, bath || corridor ? random.uniform(0.5, 0.7) : random.uniform(0.8, 1.8)));
  if (width_m < 0.45) return;
  const bool kitchen = room.kind == RoomKind::kitchen;
  const bool french = !bath && !corridor && !kitchen && random.uniform() < 0.2;
  const double sill_m = snapped(draw_sill(room.kind, french, random));
  const double head_m = snapped(std::min(random.uniform(2.0, 2.3), room.ceiling_m - 0.12));
  for (int i = 0; i < count; ++i) {
    const double start_m = snapped(wall.low + pitch_m * (i + 0.5) - width_m / 2.0);
    const HomeWindow window{
        .room = wall.room,
        .side = wall.side,
        .recess = hole(room.floor, wall.side, start_m, snapped(start_m + width_m), kRecess_m),
        .sill_m = sill_m,
        .head_m = head_m};
    const bool at_door = std::any_of(plan.doors.begin(), plan.doors.end(), [&](const Door& door) {
      return overlap(grown(door.opening, 0.1), window.recess);
    });
    if (!at_door) plan.windows.push_back(window);
  }
}

}  // namespace

bool add_openings(FloorPlan& plan, RandomStream& random) {
  plan.doors.clear();
  plan.windows.clear();
  if (!add_inner_doors(plan, random)) return false;
  const std::vector<WallPiece> walls = outer_walls(plan);
  if (!add_front_door(plan, walls, random)) return false;
  unhang_striking_leaves(plan);
  for (const WallPiece& wall : walls) add_windows_to(plan, wall, random);
  return true;
}

}  // namespace earpoint

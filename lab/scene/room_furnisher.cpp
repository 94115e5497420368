#include "room_furnisher.h"

#include "home_shell.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kDoorDepth_m = 0.8;  ///< of floor kept free before a doorway
constexpr double kWalkerRadius_m = 0.24;
constexpr double kCell_m = 0.1;       ///< of the grid for testing paths
constexpr double kStepOver_m = 0.03;  ///< lower things do not block a path
constexpr double kPassUnder_m = 1.9;  ///< things above this do not either
constexpr double kLeastFreeShare = 0.3;
constexpr int kTries = 40;

bool along_y(Side side) { return side == Side::x_low || side == Side::x_high; }

double yaw_from_wall(Side side) {
  switch (side) {
    case Side::x_low:
      return 0.0;
    case Side::x_high:
      return kPi;
    case Side::y_low:
      return kPi / 2;
    case Side::y_high:
      return -kPi / 2;
  }
  return 0.0;
}

bool boxes_overlap(const Taken& a, const Taken& b) {
  return overlap(a.floor, b.floor) && a.z_low_m < b.z_high_m && b.z_low_m < a.z_high_m;
}

/// The floor in front of a doorway, inside the room.
FloorRectangle before_door(const Door& door, const FloorRectangle& floor) {
  FloorRectangle zone = grown(door.opening, 0.0);
  if (along_y(door.side_of_a)) {
    zone.x_min -= kDoorDepth_m;
    zone.x_max += kDoorDepth_m;
  } else {
    zone.y_min -= kDoorDepth_m;
    zone.y_max += kDoorDepth_m;
  }
  return {std::max(zone.x_min, floor.x_min), std::max(zone.y_min, floor.y_min),
          std::min(zone.x_max, floor.x_max), std::min(zone.y_max, floor.y_max)};
}

}  // namespace

FloorRectangle footprint_of(const Vector3& size_m, const Placement& placement) {
  const double c = std::abs(std::cos(placement.yaw_rad));
  const double s = std::abs(std::sin(placement.yaw_rad));
  const double half_x = (c * size_m.x + s * size_m.y) / 2.0;
  const double half_y = (s * size_m.x + c * size_m.y) / 2.0;
  const Vector3& p = placement.position_m;
  return {p.x - half_x, p.y - half_y, p.x + half_x, p.y + half_y};
}

RoomFurnisher::RoomFurnisher(Shared& shared, int room, RandomStream random)
    : shared_(shared),
      index_(room),
      room_(shared.plan.rooms[static_cast<std::size_t>(room)]),
      random_(random) {
  for (const Door& door : shared.plan.doors) {
    if (door.room_a != room && door.room_b != room) continue;
    const FloorRectangle zone = before_door(door, room_.floor);
    kept_free_.push_back({zone, 0.0, 2.2});
    doorsteps_.push_back({zone.centre_x(), zone.centre_y(), 0.0});
    if (door.state == DoorState::open && door.room_a == room) {
      leaves_.push_back({leaf_footprint(shared.plan, door), 0.0, door.height_m});
    }
  }
}

std::size_t RoomFurnisher::triangles_left() const {
  const std::size_t used = shared_.builder.scene().mesh.triangles.size();
  return shared_.most_triangles > used ? shared_.most_triangles - used : 0;
}

std::optional<FurniturePiece> RoomFurnisher::draw(FurnitureKind kind, const Vector3& limit_m) {
  // One piece takes at most a sixth of the triangles left, so that the last rooms get models too.
  return draw_furniture(shared_.catalogue, kind, limit_m, triangles_left() / 6, random_);
}

double RoomFurnisher::wall_length_m(Side side) const {
  return along_y(side) ? room_.floor.depth_m() : room_.floor.width_m();
}

std::vector<const HomeWindow*> RoomFurnisher::windows() const {
  std::vector<const HomeWindow*> found;
  for (const HomeWindow& window : shared_.plan.windows) {
    if (window.room == index_) found.push_back(&window);
  }
  return found;
}

bool RoomFurnisher::is_taken(const Taken& box) const {
  const auto hits = [&](const Taken& other) { return boxes_overlap(box, other); };
  return std::any_of(taken_.begin(), taken_.end(), hits) ||
         std::any_of(leaves_.begin(), leaves_.end(), hits) ||
         std::any_of(kept_free_.begin(), kept_free_.end(), hits);
}

bool RoomFurnisher::rug_fits(const Taken& box) const {
  const auto hits = [&](const Taken& other) { return overlap(box.floor, other.floor); };
  return std::none_of(rugs_.begin(), rugs_.end(), hits) &&
         std::none_of(leaves_.begin(), leaves_.end(), hits);
}

bool RoomFurnisher::hides_window(const Taken& box, Side side) const {
  for (const HomeWindow* window : windows()) {
    if (window->side != side || box.z_high_m <= window->sill_m || box.z_low_m >= window->head_m) {
      continue;
    }
    const bool beside =
        along_y(side)
            ? box.floor.y_max <= window->recess.y_min || box.floor.y_min >= window->recess.y_max
            : box.floor.x_max <= window->recess.x_min || box.floor.x_min >= window->recess.x_max;
    if (!beside) return true;
  }
  return false;
}

bool RoomFurnisher::ways_are_free() const {
  const FloorRectangle& floor = room_.floor;
  const int columns = static_cast<int>(floor.width_m() / kCell_m);
  const int rows = static_cast<int>(floor.depth_m() / kCell_m);
  std::vector<char> walkable(static_cast<std::size_t>(columns) * rows, 1);
  const auto cell_of = [&](double x, double y) {
    const int i = std::clamp(static_cast<int>((x - floor.x_min) / kCell_m), 0, columns - 1);
    const int j = std::clamp(static_cast<int>((y - floor.y_min) / kCell_m), 0, rows - 1);
    return static_cast<std::size_t>(j) * columns + i;
  };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const double x = floor.x_min + (i + 0.5) * kCell_m;
      const double y = floor.y_min + (j + 0.5) * kCell_m;
      for (const Taken& box : taken_) {
        if (box.z_low_m > kPassUnder_m || !grown(box.floor, kWalkerRadius_m).contains(x, y))
          continue;
        walkable[static_cast<std::size_t>(j) * columns + i] = 0;
        break;
      }
    }
  }
  const auto free_cells = static_cast<double>(std::count(walkable.begin(), walkable.end(), 1));
  if (free_cells < kLeastFreeShare * static_cast<double>(walkable.size())) return false;
  // Flood fill from the first doorway; 2 marks visited cells.
  std::vector<std::size_t> front;
  const auto visit = [&](std::size_t cell) {
    if (walkable[cell] != 1) return;
    walkable[cell] = 2;
    front.push_back(cell);
  };
  visit(cell_of(doorsteps_[0].x, doorsteps_[0].y));
  while (!front.empty()) {
    const std::size_t cell = front.back();
    front.pop_back();
    const auto i = static_cast<int>(cell % static_cast<std::size_t>(columns));
    const auto j = static_cast<int>(cell / static_cast<std::size_t>(columns));
    if (i > 0) visit(cell - 1);
    if (i + 1 < columns) visit(cell + 1);
    if (j > 0) visit(cell - static_cast<std::size_t>(columns));
    if (j + 1 < rows) visit(cell + static_cast<std::size_t>(columns));
  }
  return std::all_of(doorsteps_.begin(), doorsteps_.end(),
                     [&](const Vector3& step) { return walkable[cell_of(step.x, step.y)] == 2; });
}

std::optional<PlacedFurniture> RoomFurnisher::place(const FurniturePiece& piece,
                                                    const Placement& placement,
                                                    bool stands_on_floor) {
  const Taken box{footprint_of(piece.size_m, placement), placement.position_m.z,
                  placement.position_m.z + piece.size_m.z};
  const FloorRectangle& floor = room_.floor;
  const bool inside = box.floor.x_min >= floor.x_min && box.floor.y_min >= floor.y_min &&
                      box.floor.x_max <= floor.x_max && box.floor.y_max <= floor.y_max &&
                      box.z_high_m <= room_.ceiling_m;
  // Things may stand on a rug, which must avoid only other rugs and the swing of doors.
  const bool flat = piece.size_m.z < kStepOver_m;
  if (!inside || (flat ? !rug_fits(box) : is_taken(box))) return std::nullopt;
  std::vector<Taken>& list = flat ? rugs_ : taken_;
  list.push_back(box);
  if (stands_on_floor && !flat && !ways_are_free()) {
    list.pop_back();
    return std::nullopt;
  }
  PlacedFurniture placed_piece;
  placed_piece.kind = piece.kind;
  placed_piece.room = index_;
  placed_piece.footprint = box.floor;
  placed_piece.z_low_m = box.z_low_m;
  placed_piece.z_high_m = box.z_high_m;
  placed_piece.yaw_rad = placement.yaw_rad;
  placed_piece.instance = add_furniture(piece, shared_.style, placement, shared_.builder);
  placed_piece.name = shared_.builder.scene().instances.back().name;
  shared_.furniture.push_back(placed_piece);
  return placed_piece;
}

std::optional<PlacedFurniture> RoomFurnisher::place_at(const FurniturePiece& piece,
                                                       const WallSpot& spot, double clearance_m) {
  const FloorRectangle& floor = room_.floor;
  const double out_m = spot.gap_m + piece.size_m.x / 2.0;
  Placement placement;
  placement.yaw_rad = yaw_from_wall(spot.side);
  placement.position_m = along_y(spot.side) ? Vector3{0.0, spot.along_m, spot.base_m}
                                            : Vector3{spot.along_m, 0.0, spot.base_m};
  switch (spot.side) {
    case Side::x_low:
      placement.position_m.x = floor.x_min + out_m;
      break;
    case Side::x_high:
      placement.position_m.x = floor.x_max - out_m;
      break;
    case Side::y_low:
      placement.position_m.y = floor.y_min + out_m;
      break;
    case Side::y_high:
      placement.position_m.y = floor.y_max - out_m;
      break;
  }
  Taken box{footprint_of(piece.size_m, placement), spot.base_m, spot.base_m + piece.size_m.z};
  const bool dresses_window =
      piece.kind == FurnitureKind::curtain || piece.kind == FurnitureKind::blinds;
  if (!dresses_window && hides_window(box, spot.side)) return std::nullopt;
  if (clearance_m > 0.0) {
    Placement before = placement;
    before.position_m = placement.position_m +
                        (piece.size_m.x / 2.0 + clearance_m / 2.0) *
                            Vector3{std::cos(placement.yaw_rad), std::sin(placement.yaw_rad), 0.0};
    box.floor = footprint_of({clearance_m, piece.size_m.y, 1.0}, before);
    const auto hits = [&](const Taken& other) { return boxes_overlap(box, other); };
    if (std::any_of(taken_.begin(), taken_.end(), hits)) return std::nullopt;
  }
  return place(piece, placement, spot.base_m < kPassUnder_m);
}

std::optional<PlacedFurniture> RoomFurnisher::place_at_wall(FurnitureKind kind,
                                                            const Vector3& limit_m,
                                                            double clearance_m, double base_m) {
  const std::optional<FurniturePiece> piece = draw(kind, limit_m);
  if (!piece) return std::nullopt;
  constexpr std::array<Side, 4> kSides = {Side::x_low, Side::x_high, Side::y_low, Side::y_high};
  for (int i = 0; i < kTries; ++i) {
    const Side side = kSides[random_.index(kSides.size())];
    const double slack_m = wall_length_m(side) - piece->size_m.y - 0.04;
    if (slack_m < 0.0) continue;
    const double first_m = along_y(side) ? room_.floor.y_min : room_.floor.x_min;
    // A third of the pieces goes into a corner, as in real homes.
    const double draw = random_.uniform(-0.25, 1.25);
    const double along_m =
        first_m + 0.02 + std::clamp(draw, 0.0, 1.0) * slack_m + piece->size_m.y / 2.0;
    auto found = place_at(
        *piece, {.side = side, .along_m = along_m, .gap_m = 0.02, .base_m = base_m}, clearance_m);
    if (found) return found;
  }
  return std::nullopt;
}

std::optional<PlacedFurniture> RoomFurnisher::place_on(FurnitureKind kind,
                                                       const PlacedFurniture& base) {
  const bool turned = std::abs(std::sin(base.yaw_rad)) > 0.7;
  const double depth_m = turned ? base.footprint.depth_m() : base.footprint.width_m();
  const double width_m = turned ? base.footprint.width_m() : base.footprint.depth_m();
  const double room_above_m = room_.ceiling_m - base.z_high_m - 0.1;
  const auto piece = draw(kind, {depth_m, width_m, room_above_m});
  if (!piece) return std::nullopt;
  Placement placement;
  placement.position_m = {base.footprint.centre_x(), base.footprint.centre_y(),
                          base.z_high_m + 0.002};
  placement.yaw_rad = base.yaw_rad;
  return place(*piece, placement, false);
}

std::optional<PlacedFurniture> RoomFurnisher::place_before(FurnitureKind kind,
                                                           const PlacedFurniture& anchor,
                                                           const Vector3& limit_m, double gap_m,
                                                           bool facing_back) {
  const auto piece = draw(kind, limit_m);
  if (!piece) return std::nullopt;
  const bool turned = std::abs(std::sin(anchor.yaw_rad)) > 0.7;
  const double anchor_depth_m = turned ? anchor.footprint.depth_m() : anchor.footprint.width_m();
  const double reach_m = anchor_depth_m / 2.0 + gap_m + piece->size_m.x / 2.0;
  Placement placement;
  placement.position_m = {anchor.footprint.centre_x() + reach_m * std::cos(anchor.yaw_rad),
                          anchor.footprint.centre_y() + reach_m * std::sin(anchor.yaw_rad), 0.0};
  placement.yaw_rad = wrap_angle(anchor.yaw_rad + (facing_back ? kPi : 0.0));
  return place(*piece, placement);
}

Side RoomFurnisher::side_behind(const PlacedFurniture& piece) {
  const double c = std::cos(piece.yaw_rad);
  const double s = std::sin(piece.yaw_rad);
  if (std::abs(c) > std::abs(s)) return c > 0.0 ? Side::x_low : Side::x_high;
  return s > 0.0 ? Side::y_low : Side::y_high;
}

}  // namespace earpoint

#include "home_shell.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kSolid = -1;

/// A box of air and the materials of its walls.
struct AirBox {
  enum class Kind { room, doorway, front_doorway, recess };

  Kind kind = Kind::room;
  int index = 0;  ///< of the room, door or window
  FloorRectangle floor;
  double z_low = 0.0;
  double z_high = 0.0;
  Side outer = Side::x_low;  ///< where the pane or the front door stands
};

FloorRectangle half_of(const FloorRectangle& r, bool across_x, bool high) {
  FloorRectangle half = r;
  // Whole centimetres, as everything in a plan.
  if (across_x) {
    const double middle = std::round(r.centre_x() * 100.0) / 100.0;
    (high ? half.x_min : half.x_max) = middle;
  } else {
    const double middle = std::round(r.centre_y() * 100.0) / 100.0;
    (high ? half.y_min : half.y_max) = middle;
  }
  return half;
}

bool faces_x(Side side) { return side == Side::x_low || side == Side::x_high; }

std::vector<AirBox> air_of(const FloorPlan& plan) {
  std::vector<AirBox> boxes;
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    boxes.push_back({.kind = AirBox::Kind::room,
                     .index = static_cast<int>(i),
                     .floor = plan.rooms[i].floor,
                     .z_low = 0.0,
                     .z_high = plan.rooms[i].ceiling_m});
  }
  for (std::size_t i = 0; i < plan.doors.size(); ++i) {
    const Door& door = plan.doors[i];
    AirBox box{.kind = AirBox::Kind::doorway,
               .index = static_cast<int>(i),
               .floor = door.opening,
               .z_low = 0.0,
               .z_high = door.height_m,
               .outer = door.side_of_a};
    if (door.room_b == Door::kOutside) {
      box.kind = AirBox::Kind::front_doorway;
      boxes.push_back(box);
      continue;
    }
    // Two halves, with a closed leaf between them.
    for (const bool high : {false, true}) {
      box.floor = half_of(door.opening, faces_x(door.side_of_a), high);
      boxes.push_back(box);
    }
  }
  for (std::size_t i = 0; i < plan.windows.size(); ++i) {
    const HomeWindow& window = plan.windows[i];
    boxes.push_back({.kind = AirBox::Kind::recess,
                     .index = static_cast<int>(i),
                     .floor = window.recess,
                     .z_low = window.sill_m,
                     .z_high = window.head_m,
                     .outer = window.side});
  }
  return boxes;
}

/// The planes that cut space along one axis, in whole centimetres, ascending.
class GridLines {
 public:
  void add(double metres) { lines_.insert(std::lround(metres * 100.0)); }
  void freeze() { values_.assign(lines_.begin(), lines_.end()); }
  [[nodiscard]] int cells() const { return static_cast<int>(values_.size()) - 1; }
  [[nodiscard]] double at(int line) const {
    return static_cast<double>(values_[static_cast<std::size_t>(line)]) / 100.0;
  }
  [[nodiscard]] int index(double metres) const {
    const auto found =
        std::lower_bound(values_.begin(), values_.end(), std::lround(metres * 100.0));
    return static_cast<int>(found - values_.begin());
  }

 private:
  std::set<long> lines_;
  std::vector<long> values_;
};

/// Space divided into cells, each solid or in one of the boxes of air.
class CellGrid {
 public:
  explicit CellGrid(std::vector<AirBox> boxes) : boxes_(std::move(boxes)) {
    for (const AirBox& box : boxes_) {
      for (const double x : {box.floor.x_min, box.floor.x_max}) lines_[0].add(x);
      for (const double y : {box.floor.y_min, box.floor.y_max}) lines_[1].add(y);
      for (const double z : {box.z_low, box.z_high}) lines_[2].add(z);
    }
    for (GridLines& lines : lines_) lines.freeze();
    owner_.assign(
        static_cast<std::size_t>(lines_[0].cells()) * lines_[1].cells() * lines_[2].cells(),
        kSolid);
    for (std::size_t i = 0; i < boxes_.size(); ++i) fill(boxes_[i], static_cast<int>(i));
  }

  [[nodiscard]] const AirBox& box(int owner) const {
    return boxes_[static_cast<std::size_t>(owner)];
  }
  [[nodiscard]] int cells(int axis) const { return lines_[axis].cells(); }
  [[nodiscard]] double line(int axis, int index) const { return lines_[axis].at(index); }

  /// @return the index of the box that the cell lies in; kSolid for walls and what lies outside
  [[nodiscard]] int owner(const std::array<int, 3>& cell) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (cell[axis] < 0 || cell[axis] >= cells(axis)) return kSolid;
    }
    return owner_[position(cell)];
  }

 private:
  void fill(const AirBox& box, int owner) {
    std::array<int, 3> cell{};
    for (cell[2] = lines_[2].index(box.z_low); cell[2] < lines_[2].index(box.z_high); ++cell[2]) {
      for (cell[1] = lines_[1].index(box.floor.y_min); cell[1] < lines_[1].index(box.floor.y_max);
           ++cell[1]) {
        for (cell[0] = lines_[0].index(box.floor.x_min); cell[0] < lines_[0].index(box.floor.x_max);
             ++cell[0]) {
          EARPOINT_CHECK(owner_[position(cell)] == kSolid);
          owner_[position(cell)] = owner;
        }
      }
    }
  }
  [[nodiscard]] std::size_t position(const std::array<int, 3>& cell) const {
    return (static_cast<std::size_t>(cell[2]) * cells(1) + cell[1]) * cells(0) + cell[0];
  }

  std::vector<AirBox> boxes_;
  std::array<GridLines, 3> lines_;
  std::vector<int> owner_;
};

/// Direction of a face of a cell, away from the air: along an axis, towards its high or low end.
struct Outward {
  int axis;
  bool high;
};

bool is_at(Outward outward, Side side) {
  const bool high = side == Side::x_high || side == Side::y_high;
  return outward.axis == (faces_x(side) ? 0 : 1) && outward.high == high;
}

const Surface& surface_of(const FloorPlan& plan, const HomeFinish& finish, const AirBox& box,
                          Outward outward) {
  const auto& rooms = finish.rooms;
  const auto index = static_cast<std::size_t>(box.index);
  const bool down = outward.axis == 2 && !outward.high;
  switch (box.kind) {
    case AirBox::Kind::room:
      if (outward.axis == 2) return outward.high ? rooms[index].ceiling : rooms[index].floor;
      return rooms[index].wall;
    case AirBox::Kind::doorway:
    case AirBox::Kind::front_doorway:
      if (down) return rooms[static_cast<std::size_t>(plan.doors[index].room_a)].floor;
      if (box.kind == AirBox::Kind::front_doorway && is_at(outward, box.outer)) {
        return finish.front_door;
      }
      return finish.frame;
    case AirBox::Kind::recess:
      return is_at(outward, box.outer) ? finish.pane : finish.reveal;
  }
  return finish.frame;
}

/// The corners of a cell's face, counter-clockwise as seen from inside the cell.
Quad face_corners(const CellGrid& grid, const std::array<int, 3>& cell, Outward outward) {
  const int u = (outward.axis + 1) % 3;
  const int v = (outward.axis + 2) % 3;
  Quad corners;
  for (int i = 0; i < 4; ++i) {
    std::array<double, 3> p{};
    const bool second = i == 1 || i == 2;
    const bool third = i == 2 || i == 3;
    p[outward.axis] = grid.line(outward.axis, cell[outward.axis] + (outward.high ? 1 : 0));
    p[u] = grid.line(u, cell[u] + (second ? 1 : 0));
    p[v] = grid.line(v, cell[v] + (third ? 1 : 0));
    corners[static_cast<std::size_t>(i)] = {p[0], p[1], p[2]};
  }
  // u, v and the axis are right-handed, so the normal of this loop points up the axis: outwards at
  // a high face.
  if (outward.high) std::swap(corners[1], corners[3]);
  return corners;
}

/// Texture coordinates that stretch one picture over a whole upright rectangle.
std::array<std::array<float, 2>, 4> spread(const Quad& corners, const FloorRectangle& floor,
                                           double z_low, double z_high, Outward outward) {
  const Vector3 inward{outward.axis == 0 ? (outward.high ? -1.0 : 1.0) : 0.0,
                       outward.axis == 1 ? (outward.high ? -1.0 : 1.0) : 0.0, 0.0};
  const Vector3 right = cross({0, 0, 1}, inward);
  const Vector3 low{floor.x_min, floor.y_min, z_low};
  const Vector3 high{floor.x_max, floor.y_max, z_high};
  const double first = std::min(dot(low, right), dot(high, right));
  const double last = std::max(dot(low, right), dot(high, right));
  std::array<std::array<float, 2>, 4> uvs{};
  for (std::size_t i = 0; i < 4; ++i) {
    uvs[i] = {static_cast<float>((dot(corners[i], right) - first) / (last - first)),
              static_cast<float>((corners[i].z - z_low) / (z_high - z_low))};
  }
  return uvs;
}

void add_face(const FloorPlan& plan, const HomeFinish& finish, const CellGrid& grid,
              const std::array<int, 3>& cell, Outward outward, SceneBuilder& builder) {
  std::array<int, 3> next = cell;
  next[outward.axis] += outward.high ? 1 : -1;
  const AirBox& box = grid.box(grid.owner(cell));
  const int neighbour = grid.owner(next);
  const Quad corners = face_corners(grid, cell, outward);
  if (neighbour != kSolid) {
    // Between two boxes of air only the leaf of a closed door is added, once.
    const AirBox& other = grid.box(neighbour);
    const bool same_door = box.kind == AirBox::Kind::doorway && other.kind == box.kind &&
                           other.index == box.index && neighbour != grid.owner(cell);
    if (!same_door || !outward.high) return;
    const Door& door = plan.doors[static_cast<std::size_t>(box.index)];
    if (door.state != DoorState::closed) return;
    builder.add_quad(corners, finish.door,
                     spread(corners, door.opening, 0.0, door.height_m, outward));
    return;
  }
  const Surface& surface = surface_of(plan, finish, box, outward);
  const bool whole =
      outward.axis != 2 && box.kind != AirBox::Kind::room && is_at(outward, box.outer);
  if (whole && box.kind != AirBox::Kind::doorway) {
    builder.add_quad(corners, surface, spread(corners, box.floor, box.z_low, box.z_high, outward));
  } else {
    builder.add_quad(corners, surface);
  }
}

}  // namespace

void add_shell(const FloorPlan& plan, const HomeFinish& finish, SceneBuilder& builder) {
  EARPOINT_CHECK(finish.rooms.size() == plan.rooms.size());
  const CellGrid grid(air_of(plan));
  builder.begin_instance("shell", InstanceKind::structure);
  std::array<int, 3> cell{};
  for (cell[2] = 0; cell[2] < grid.cells(2); ++cell[2]) {
    for (cell[1] = 0; cell[1] < grid.cells(1); ++cell[1]) {
      for (cell[0] = 0; cell[0] < grid.cells(0); ++cell[0]) {
        if (grid.owner(cell) == kSolid) continue;
        for (int axis = 0; axis < 3; ++axis) {
          for (const bool high : {false, true}) {
            add_face(plan, finish, grid, cell, {axis, high}, builder);
          }
        }
      }
    }
  }
}

}  // namespace earpoint

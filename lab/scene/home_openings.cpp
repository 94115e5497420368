#include "home_shell.h"

#include <algorithm>

#include <earpoint/pose.h>

namespace earpoint {

namespace {

constexpr double kLeafThickness_m = 0.04;

bool faces_x(Side side) { return side == Side::x_low || side == Side::x_high; }

/// The leaf's local frame: x along the leaf from the hinge, y towards the side that it opens to.
Placement leaf_placement(const FloorPlan& plan, const Door& door) {
  const FloorRectangle& floor = plan.rooms[static_cast<std::size_t>(door.room_a)].floor;
  const bool across_x = faces_x(door.side_of_a);
  const double along = across_x
                           ? (door.hinge_at_high_end ? door.opening.y_max : door.opening.y_min)
                           : (door.hinge_at_high_end ? door.opening.x_max : door.opening.x_min);
  // The hinge is on the wall's surface in room_a; the closed leaf points to the other jamb.
  Placement placement;
  double closed_rad = 0.0;
  double turn = 1.0;  // counter-clockwise into the room
  switch (door.side_of_a) {
    case Side::x_low:
      placement.position_m = {floor.x_min, along, 0.0};
      closed_rad = door.hinge_at_high_end ? -kPi / 2 : kPi / 2;
      turn = door.hinge_at_high_end ? 1.0 : -1.0;
      break;
    case Side::x_high:
      placement.position_m = {floor.x_max, along, 0.0};
      closed_rad = door.hinge_at_high_end ? -kPi / 2 : kPi / 2;
      turn = door.hinge_at_high_end ? -1.0 : 1.0;
      break;
    case Side::y_low:
      placement.position_m = {along, floor.y_min, 0.0};
      closed_rad = door.hinge_at_high_end ? kPi : 0.0;
      turn = door.hinge_at_high_end ? -1.0 : 1.0;
      break;
    case Side::y_high:
      placement.position_m = {along, floor.y_max, 0.0};
      closed_rad = door.hinge_at_high_end ? kPi : 0.0;
      turn = door.hinge_at_high_end ? 1.0 : -1.0;
      break;
  }
  placement.yaw_rad = closed_rad + turn * door.leaf_angle_rad;
  return placement;
}

double width_of(const Door& door) {
  return faces_x(door.side_of_a) ? door.opening.depth_m() : door.opening.width_m();
}

/// A gap to the wall, so that the leaf's box touches nothing.
constexpr double kHingeGap_m = 0.03;

Vector3 leaf_low(const Door&) { return {kHingeGap_m, -kLeafThickness_m / 2, 0.008}; }
Vector3 leaf_high(const Door& door) {
  return {width_of(door), kLeafThickness_m / 2, door.height_m - 0.008};
}

void add_leaf(const FloorPlan& plan, const Door& door, const HomeFinish& finish,
              SceneBuilder& builder) {
  builder.begin_instance("door leaf", InstanceKind::structure, leaf_placement(plan, door));
  const Vector3 low = leaf_low(door);
  const Vector3 high = leaf_high(door);
  // The two large faces carry the picture of a door, its handle away from the hinge.
  const auto corner = [&](bool x, bool y, bool z) {
    return Vector3{x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z};
  };
  builder.add_quad({corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1)},
                   finish.door, {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}});
  builder.add_quad({corner(1, 1, 0), corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1)},
                   finish.door, {{{1, 0}, {0, 0}, {0, 1}, {1, 1}}});
  builder.add_quad({corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1)},
                   finish.frame);
  builder.add_quad({corner(0, 1, 0), corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1)},
                   finish.frame);
  builder.add_quad({corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)},
                   finish.frame);
  builder.add_quad({corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0), corner(0, 0, 0)},
                   finish.frame);
}

/// A frame around the pane and a bar or two across, as thin boxes.
void add_window_frame(const HomeWindow& window, const HomeFinish& finish, SceneBuilder& builder) {
  constexpr double kBar_m = 0.06;
  constexpr double kDepth_m = 0.05;
  constexpr double kGap_m = 0.01;  // off the pane and the recess's sides
  const bool across_x = faces_x(window.side);
  const FloorRectangle& r = window.recess;
  const bool high = window.side == Side::x_high || window.side == Side::y_high;
  const double pane = across_x ? (high ? r.x_max : r.x_min) : (high ? r.y_max : r.y_min);
  const double out = high ? pane - kGap_m : pane + kGap_m;
  const double in = high ? out - kDepth_m : out + kDepth_m;
  const double first = (across_x ? r.y_min : r.x_min) + kGap_m;
  const double last = (across_x ? r.y_max : r.x_max) - kGap_m;
  builder.begin_instance("window frame", InstanceKind::structure);
  const auto bar = [&](double along_low, double along_high, double z_low, double z_high) {
    const double low = std::min(in, out);
    const double top = std::max(in, out);
    builder.add_box(across_x ? Vector3{low, along_low, z_low} : Vector3{along_low, low, z_low},
                    across_x ? Vector3{top, along_high, z_high} : Vector3{along_high, top, z_high},
                    finish.reveal);
  };
  const double bottom = window.sill_m + kGap_m;
  const double top = window.head_m - kGap_m;
  bar(first, last, bottom, bottom + kBar_m);
  bar(first, last, top - kBar_m, top);
  const int bays = last - first > 0.9 ? 2 : 1;
  for (int i = 0; i <= bays; ++i) {
    const double left = first + (last - first - kBar_m) * i / bays;
    bar(left, left + kBar_m, bottom + kBar_m, top - kBar_m);
  }
}

}  // namespace

FloorRectangle leaf_footprint(const FloorPlan& plan, const Door& door) {
  if (door.state != DoorState::open) return {};
  const Placement placement = leaf_placement(plan, door);
  const Vector3 low = leaf_low(door);
  const Vector3 high = leaf_high(door);
  FloorRectangle around{1e9, 1e9, -1e9, -1e9};
  for (const double x : {low.x, high.x}) {
    for (const double y : {low.y, high.y}) {
      const Vector3 corner = placed(placement, {x, y, 0.0});
      around = {std::min(around.x_min, corner.x), std::min(around.y_min, corner.y),
                std::max(around.x_max, corner.x), std::max(around.y_max, corner.y)};
    }
  }
  return around;
}

void add_leaves_and_frames(const FloorPlan& plan, const HomeFinish& finish, SceneBuilder& builder) {
  for (const Door& door : plan.doors) {
    if (door.state == DoorState::open) add_leaf(plan, door, finish, builder);
  }
  for (const HomeWindow& window : plan.windows) add_window_frame(window, finish, builder);
}

}  // namespace earpoint

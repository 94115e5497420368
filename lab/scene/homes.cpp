#include <earpoint/scene/homes.h>

#include "home_finish.h"
#include "home_shell.h"
#include "room_furnisher.h"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

/// Keys of the random streams of a home: a draw from one does not shift the others.
enum StreamKey : std::uint64_t { kPlanKey = 1, kFinishKey, kStyleKey, kRoomKey };

/// Range of the softness that is drawn if the options do not set it. The traced reverberation time
/// of nearly all rooms is then 0.2 to 1 s, as in real homes (docs/results.md). Harder and softer
/// homes must be requested.
constexpr double kHardestHome = 0.58;
constexpr double kSoftestHome = 0.98;
constexpr double kEmptiestHome = 0.45;

/// Lamps are below their fixtures, which would otherwise shade the ceiling.
constexpr double kLampDrop_m = 0.25;

constexpr double kStepOver_m = 0.03;
constexpr double kPassUnder_m = 2.0;

void check_share(const char* field, const std::optional<double>& value) {
  if (!value || (*value >= 0.0 && *value <= 1.0)) return;
  throw InputError(fmt::format("home: {}", field),
                   fmt::format("expected 0 to 1, found {}", *value));
}

/// One lamp under each room's ceiling lamp, or in the middle where there is none.
void add_lamps(const FloorPlan& plan, const std::vector<PlacedFurniture>& furniture,
               SceneBuilder& builder) {
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    const Room& room = plan.rooms[i];
    Vector3 at{room.floor.centre_x(), room.floor.centre_y(), room.ceiling_m - kLampDrop_m};
    for (const PlacedFurniture& piece : furniture) {
      if (piece.kind != FurnitureKind::ceiling_lamp || piece.room != static_cast<int>(i)) continue;
      at = {piece.footprint.centre_x(), piece.footprint.centre_y(), piece.z_low_m - kLampDrop_m};
    }
    // Bright enough that a white floor below looks white without exposure correction.
    const double height_m = room.ceiling_m;
    const auto intensity = static_cast<float>(
        std::clamp(0.25 * room.floor.area_m2(), 0.8 * height_m * height_m, 20.0));
    builder.add_lamp({.position_m = at,
                      .intensity = {intensity, 0.95F * intensity, 0.85F * intensity},
                      .radius_m = 0.08F});
  }
}

bool blocks_walker(const PlacedFurniture& piece) {
  return piece.z_high_m > kStepOver_m && piece.z_low_m < kPassUnder_m;
}

}  // namespace

Home make_home(std::uint64_t seed, const HomeOptions& options, const FurnitureLibrary& library) {
  check_share("softness", options.softness);
  check_share("furnishing", options.furnishing);
  Home home;
  RandomStream plan_random(seed, {kPlanKey});
  home.plan = draw_floor_plan(options.plan, plan_random);
  RandomStream style_random(seed, {kStyleKey});
  const double softness = style_random.uniform(kHardestHome, kSoftestHome);
  const double furnishing = style_random.uniform(kEmptiestHome, 1.0);
  home.softness = options.softness.value_or(softness);
  home.furnishing = options.furnishing.value_or(furnishing);
  FurnitureStyle style = draw_furniture_style(style_random);
  // Heavy curtains go with soft rooms.
  style.curtain_sound = home.softness < 0.35  ? "curtain_velvet"
                        : home.softness < 0.7 ? "curtain_light"
                                              : "curtain_heavy";

  SceneBuilder builder;
  RandomStream finish_random(seed, {kFinishKey});
  const HomeFinish finish = draw_home_finish(home.plan, home.softness, finish_random, builder);
  add_shell(home.plan, finish, builder);
  add_skirting(home.plan, finish, builder);
  add_leaves_and_frames(home.plan, finish, builder);
  RoomFurnisher::Shared shared{home.plan, library,        style,
                               builder,   home.furniture, options.most_triangles};
  for (std::size_t i = 0; i < home.plan.rooms.size(); ++i) {
    RoomFurnisher furnisher(shared, static_cast<int>(i), RandomStream(seed, {kRoomKey, i}));
    furnish_room(furnisher, home.furnishing, home.softness);
  }
  add_lamps(home.plan, home.furniture, builder);
  home.scene = builder.take();
  check_scene(home.scene, fmt::format("home {}", seed));
  return home;
}

int room_at(const FloorPlan& plan, double x, double y) {
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    if (plan.rooms[i].floor.contains(x, y)) return static_cast<int>(i);
  }
  return -1;
}

bool is_free(const Home& home, double x, double y, double radius_m) {
  const int room = room_at(home.plan, x, y);
  if (room < 0) return false;
  const FloorRectangle inner =
      grown(home.plan.rooms[static_cast<std::size_t>(room)].floor, -radius_m);
  if (!inner.contains(x, y)) return false;
  for (const PlacedFurniture& piece : home.furniture) {
    if (blocks_walker(piece) && grown(piece.footprint, radius_m).contains(x, y)) return false;
  }
  for (const Door& door : home.plan.doors) {
    if (door.state != DoorState::open) continue;
    if (grown(leaf_footprint(home.plan, door), radius_m).contains(x, y)) return false;
  }
  return true;
}

}  // namespace earpoint

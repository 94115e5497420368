#include "home_finish.h"

#include <algorithm>
#include <span>
#include <string>

#include <earpoint/scene/material_table.h>
#include <earpoint/scene/texture.h>

namespace earpoint {
namespace {

/// A finish of a surface: its acoustic material and its look belong together.
struct Finish {
  const char* name;
  const char* acoustic;
  TexturePattern pattern;
  float roughness;
  std::array<ScreenColour, 3> colours;
};

using enum TexturePattern;

// Each list is sorted from hard to soft.
constexpr std::array<Finish, 10> kFloors = {{
    {"marble floor",
     "marble",
     marble,
     0.25F,
     {{{0.86F, 0.84F, 0.80F}, {0.55F, 0.53F, 0.50F}, {0.80F, 0.72F, 0.62F}}}},
    {"tile floor",
     "ceramic_tile",
     tiles,
     0.3F,
     {{{0.80F, 0.77F, 0.72F}, {0.62F, 0.50F, 0.42F}, {0.45F, 0.46F, 0.48F}}}},
    {"concrete floor",
     "concrete_floor",
     concrete,
     0.6F,
     {{{0.60F, 0.60F, 0.58F}, {0.52F, 0.51F, 0.49F}, {0.68F, 0.67F, 0.64F}}}},
    {"linoleum floor",
     "linoleum",
     linoleum,
     0.5F,
     {{{0.62F, 0.64F, 0.55F}, {0.72F, 0.66F, 0.55F}, {0.50F, 0.55F, 0.60F}}}},
    {"parquet floor",
     "parquet",
     parquet,
     0.4F,
     {{{0.70F, 0.50F, 0.31F}, {0.55F, 0.36F, 0.22F}, {0.80F, 0.63F, 0.43F}}}},
    {"plank floor",
     "wood_floor",
     wood_planks,
     0.45F,
     {{{0.72F, 0.56F, 0.38F}, {0.50F, 0.37F, 0.27F}, {0.82F, 0.74F, 0.62F}}}},
    {"thin carpet",
     "carpet_thin",
     carpet,
     1.0F,
     {{{0.55F, 0.55F, 0.56F}, {0.45F, 0.50F, 0.58F}, {0.60F, 0.54F, 0.46F}}}},
    {"foam-backed carpet",
     "carpet_foam",
     carpet,
     1.0F,
     {{{0.66F, 0.60F, 0.52F}, {0.50F, 0.55F, 0.48F}, {0.58F, 0.50F, 0.52F}}}},
    {"felt-backed carpet",
     "carpet_felt",
     carpet,
     1.0F,
     {{{0.62F, 0.42F, 0.36F}, {0.42F, 0.46F, 0.60F}, {0.70F, 0.66F, 0.60F}}}},
    {"thick carpet",
     "carpet_thick",
     carpet,
     1.0F,
     {{{0.78F, 0.74F, 0.68F}, {0.52F, 0.34F, 0.34F}, {0.46F, 0.44F, 0.50F}}}},
}};

constexpr std::array<Finish, 9> kWalls = {{
    {"concrete wall",
     "concrete_smooth",
     concrete,
     0.8F,
     {{{0.70F, 0.70F, 0.69F}, {0.62F, 0.62F, 0.61F}, {0.76F, 0.75F, 0.73F}}}},
    {"painted brick wall",
     "brick_painted",
     brick,
     0.7F,
     {{{0.92F, 0.91F, 0.88F}, {0.85F, 0.84F, 0.82F}, {0.80F, 0.78F, 0.74F}}}},
    {"plastered wall",
     "plaster",
     plaster,
     0.9F,
     {{{0.95F, 0.94F, 0.91F}, {0.90F, 0.88F, 0.80F}, {0.80F, 0.85F, 0.86F}}}},
    {"rough-plastered wall",
     "plaster_rough",
     plaster,
     1.0F,
     {{{0.93F, 0.90F, 0.84F}, {0.86F, 0.78F, 0.68F}, {0.90F, 0.86F, 0.82F}}}},
    {"painted plasterboard",
     "plasterboard_wall",
     plaster,
     0.85F,
     {{{0.96F, 0.96F, 0.95F}, {0.88F, 0.90F, 0.86F}, {0.92F, 0.88F, 0.86F}}}},
    {"wallpaper on plasterboard",
     "plasterboard_wall",
     wallpaper,
     0.85F,
     {{{0.76F, 0.80F, 0.74F}, {0.82F, 0.76F, 0.68F}, {0.72F, 0.76F, 0.84F}}}},
    {"open brick wall",
     "brick_open_joints",
     brick,
     0.9F,
     {{{0.62F, 0.33F, 0.25F}, {0.70F, 0.45F, 0.33F}, {0.55F, 0.38F, 0.32F}}}},
    {"wood-lined wall",
     "wood_panel",
     wood_planks,
     0.5F,
     {{{0.70F, 0.52F, 0.34F}, {0.82F, 0.70F, 0.54F}, {0.52F, 0.38F, 0.28F}}}},
    {"fabric wall panels",
     "acoustic_panel",
     fabric,
     1.0F,
     {{{0.60F, 0.58F, 0.55F}, {0.45F, 0.50F, 0.54F}, {0.66F, 0.56F, 0.48F}}}},
}};

constexpr std::array<Finish, 6> kCeilings = {{
    {"concrete ceiling",
     "concrete_smooth",
     concrete,
     0.9F,
     {{{0.75F, 0.75F, 0.74F}, {0.70F, 0.70F, 0.69F}, {0.80F, 0.79F, 0.78F}}}},
    {"plastered ceiling",
     "plaster",
     plaster,
     0.95F,
     {{{0.96F, 0.96F, 0.95F}, {0.94F, 0.93F, 0.90F}, {0.95F, 0.95F, 0.95F}}}},
    {"plasterboard ceiling",
     "plasterboard_ceiling",
     plaster,
     0.95F,
     {{{0.97F, 0.97F, 0.96F}, {0.95F, 0.94F, 0.92F}, {0.96F, 0.96F, 0.96F}}}},
    {"wood-lined ceiling",
     "wood_panel",
     wood_planks,
     0.6F,
     {{{0.78F, 0.60F, 0.40F}, {0.86F, 0.74F, 0.58F}, {0.90F, 0.88F, 0.84F}}}},
    {"acoustic plaster ceiling",
     "acoustic_plaster",
     carpet,
     1.0F,
     {{{0.93F, 0.93F, 0.92F}, {0.92F, 0.91F, 0.88F}, {0.90F, 0.90F, 0.90F}}}},
    {"acoustic tile ceiling",
     "acoustic_ceiling_tile",
     ceiling_tiles,
     1.0F,
     {{{0.93F, 0.93F, 0.92F}, {0.90F, 0.90F, 0.88F}, {0.94F, 0.94F, 0.94F}}}},
}};

// Radiance of a white patch outside: windows are the brightest surfaces of a room by day.
constexpr float kDaylight = 2.5F;

constexpr double kAcousticCeilings = 0.86;
constexpr double kFabricWalls = 0.95;

class FinishPainter {
 public:
  FinishPainter(RandomStream& random, SceneBuilder& builder) : random_(random), builder_(builder) {}

  Surface make(const Finish& finish, bool emits = false) {
    const std::size_t colour = random_.index(finish.colours.size());
    const std::string key = std::string(finish.name) + std::to_string(colour);
    Surface surface;
    if (builder_.find_surface(key, surface)) return surface;
    Material material{.acoustic = standard_material(finish.acoustic), .look = {}};
    material.look.base_colour = {1.0F, 1.0F, 1.0F};
    material.look.roughness = finish.roughness;
    material.look.texture =
        builder_.add_texture(make_texture(finish.pattern, finish.colours[colour], random_.next()));
    if (emits) material.look.emission = {kDaylight, kDaylight, kDaylight};
    return builder_.add_surface(key, material, texture_span_m(finish.pattern));
  }

  /// Picks from a list that is sorted from hard to soft, near `softness`.
  const Finish& pick(std::span<const Finish> list, double softness, double spread) {
    const double at = std::clamp(softness + spread * random_.normal(), 0.0, 0.999);
    return list[static_cast<std::size_t>(at * static_cast<double>(list.size()))];
  }

 private:
  RandomStream& random_;
  SceneBuilder& builder_;
};

RoomFinish draw_room_finish(RoomKind kind, double softness, RandomStream& random,
                            FinishPainter& painter) {
  RoomFinish finish;
  const std::span<const Finish> floors = kFloors;
  const std::span<const Finish> walls = kWalls;
  // Only the softest homes have absorbing ceilings and walls.
  const std::span<const Finish> ceilings =
      softness > kAcousticCeilings ? kCeilings : std::span<const Finish>(kCeilings).first(4);
  switch (kind) {
    case RoomKind::bathroom: {
      finish.floor = painter.make(painter.pick(floors.first(3), softness, 0.4));
      static constexpr Finish kWallTiles = {
          "wall tiles",
          "ceramic_tile",
          tiles,
          0.25F,
          {{{0.93F, 0.94F, 0.94F}, {0.78F, 0.86F, 0.88F}, {0.90F, 0.86F, 0.80F}}}};
      finish.wall = random.uniform() < 0.7
                        ? painter.make(kWallTiles)
                        : painter.make(painter.pick(walls.subspan(1, 4), softness, 0.3));
      finish.ceiling = painter.make(painter.pick(ceilings.first(3), softness, 0.3));
      return finish;
    }
    case RoomKind::kitchen:
      finish.floor = painter.make(painter.pick(floors.subspan(1, 5), softness, 0.3));
      break;
    default:
      finish.floor = painter.make(painter.pick(floors, softness, 0.12));
      break;
  }
  const std::span<const Finish> usual_walls = softness > kFabricWalls ? walls : walls.first(8);
  // Most homes have plaster or wallpaper, not brick or wood.
  finish.wall = painter.make(painter.pick(usual_walls, 0.85 * softness, 0.18));
  finish.ceiling = painter.make(painter.pick(ceilings, softness, 0.15));
  return finish;
}

}  // namespace

HomeFinish draw_home_finish(const FloorPlan& plan, double softness, RandomStream& random,
                            SceneBuilder& builder) {
  FinishPainter painter(random, builder);
  HomeFinish home;
  for (const Room& room : plan.rooms) {
    home.rooms.push_back(draw_room_finish(room.kind, softness, random, painter));
  }
  static constexpr Finish kDoor = {
      "door leaf",
      "door_wood",
      door,
      0.5F,
      {{{0.90F, 0.89F, 0.86F}, {0.66F, 0.47F, 0.30F}, {0.45F, 0.30F, 0.20F}}}};
  static constexpr Finish kFrontDoor = {
      "front door",
      "furniture_wood",
      front_door,
      0.5F,
      {{{0.35F, 0.24F, 0.18F}, {0.25F, 0.32F, 0.36F}, {0.50F, 0.20F, 0.18F}}}};
  static constexpr Finish kFrame = {
      "door frame",
      "furniture_wood",
      wood_grain,
      0.5F,
      {{{0.90F, 0.89F, 0.86F}, {0.70F, 0.52F, 0.34F}, {0.48F, 0.33F, 0.22F}}}};
  static constexpr Finish kPane = {
      "window pane",
      "glass_double",
      window_view,
      0.05F,
      {{{0.70F, 0.45F, 0.38F}, {0.60F, 0.58F, 0.55F}, {0.75F, 0.62F, 0.45F}}}};
  static constexpr Finish kReveal = {
      "window reveal",
      "plaster",
      plaster,
      0.8F,
      {{{0.95F, 0.95F, 0.94F}, {0.93F, 0.92F, 0.90F}, {0.96F, 0.96F, 0.95F}}}};
  home.door = painter.make(kDoor);
  home.front_door = painter.make(kFrontDoor);
  home.frame = painter.make(kFrame);
  home.pane = painter.make(kPane, true);
  home.reveal = painter.make(kReveal);
  return home;
}

}  // namespace earpoint

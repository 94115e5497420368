#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/scene/floor_plan.h>
#include <earpoint/scene/furniture.h>
#include <earpoint/scene/scene.h>

namespace earpoint {

/// A piece of furniture where it stands.
struct PlacedFurniture {
  FurnitureKind kind = FurnitureKind::sofa;
  std::string name;          ///< the model's, or the kind's for a stand-in
  int room = 0;              ///< index into FloorPlan::rooms
  FloorRectangle footprint;  ///< around the turned piece
  double z_low_m = 0.0;
  double z_high_m = 0.0;
  double yaw_rad = 0.0;        ///< of its front
  std::uint32_t instance = 0;  ///< index into Scene::instances
};

/// What a home is made for; what is left open is drawn from the seed.
struct HomeOptions {
  PlanOptions plan{};
  /// 0 is bare and hard (stone, concrete, no curtains), 1 is soft (carpets, heavy curtains,
  /// absorbing ceilings).
  std::optional<double> softness{};
  /// 0 is empty, 1 is as full as fits.
  std::optional<double> furnishing{};
  /// Models with fewer triangles, or stand-ins, once a home has this many.
  std::size_t most_triangles = 60'000;
};

struct Home {
  Scene scene;  ///< closed; checked with check_scene
  FloorPlan plan;
  std::vector<PlacedFurniture> furniture;
  double softness = 0.0;
  double furnishing = 0.0;
};

/// Draws a furnished home. The same seed, options and library give the same home, byte for byte.
///
/// Every surface carries a standard acoustic material and a look that fits it. The shell (walls,
/// floors, ceilings) is one closed surface; door leaves and furniture are things in it.
/// @throws InputError if an option is out of range
Home make_home(std::uint64_t seed, const HomeOptions& options, const FurnitureLibrary& library);

/// @return the room that holds a point of the floor; -1 in walls, doorways and outside
int room_at(const FloorPlan& plan, double x, double y);

/// @return whether a person of that radius can stand there: inside a room, not in furniture (rugs
///         and what hangs above 2 m do not count), a door leaf or a wall
bool is_free(const Home& home, double x, double y, double radius_m);

}  // namespace earpoint

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include <earpoint/scene/homes.h>

namespace earpoint {

/// A box of room that something takes.
struct Taken {
  FloorRectangle floor;
  double z_low_m = 0.0;
  double z_high_m = 0.0;
};

/// Where along a wall a piece goes.
struct WallSpot {
  Side side = Side::x_low;
  double along_m = 0.0;  ///< of the piece's middle, in room coordinates
  double gap_m = 0.02;   ///< between wall and back
  double base_m = 0.0;   ///< of the piece above the floor
};

/// Puts furniture into one room: nothing overlaps, doors stay free, and one can walk from every
/// door to every other.
class RoomFurnisher {
 public:
  /// What all rooms of a home share; must outlive the furnisher.
  struct Shared {
    const FloorPlan& plan;
    const FurnitureLibrary& catalogue;
    const FurnitureStyle& style;
    SceneBuilder& builder;
    std::vector<PlacedFurniture>& furniture;
    std::size_t most_triangles;
  };

  RoomFurnisher(Shared& shared, int room, RandomStream random);

  [[nodiscard]] const Room& room() const { return room_; }
  [[nodiscard]] RandomStream& random() { return random_; }
  [[nodiscard]] bool chance(double share) { return random_.uniform() < share; }

  /// Draws a piece no larger than the limit.
  std::optional<FurniturePiece> draw(FurnitureKind kind, const Vector3& limit_m);

  /// Places a piece with its back to a wall, at a random free spot.
  /// @param clearance_m  of free floor wanted in front
  std::optional<PlacedFurniture> place_at_wall(FurnitureKind kind, const Vector3& limit_m,
                                               double clearance_m, double base_m = 0.0);

  /// Places a given piece with its back to a wall.
  std::optional<PlacedFurniture> place_at(const FurniturePiece& piece, const WallSpot& spot,
                                          double clearance_m);

  /// Places a given piece anywhere.
  /// @param stands_on_floor  it blocks the way; rugs and lamps on tables do not
  std::optional<PlacedFurniture> place(const FurniturePiece& piece, const Placement& placement,
                                       bool stands_on_floor = true);

  /// Places a piece on top of another, turned like it.
  std::optional<PlacedFurniture> place_on(FurnitureKind kind, const PlacedFurniture& base);

  /// Places a piece before another, facing the same way (or back at it).
  std::optional<PlacedFurniture> place_before(FurnitureKind kind, const PlacedFurniture& anchor,
                                              const Vector3& limit_m, double gap_m,
                                              bool facing_back);

  /// @return the wall that the piece's back is at
  static Side side_behind(const PlacedFurniture& piece);

  [[nodiscard]] double wall_length_m(Side side) const;

  /// @return windows of this room
  [[nodiscard]] std::vector<const HomeWindow*> windows() const;

 private:
  [[nodiscard]] bool is_taken(const Taken& box) const;
  [[nodiscard]] bool rug_fits(const Taken& box) const;
  [[nodiscard]] bool hides_window(const Taken& box, Side side) const;
  [[nodiscard]] bool ways_are_free() const;
  [[nodiscard]] std::size_t triangles_left() const;

  Shared& shared_;
  int index_;
  const Room& room_;
  RandomStream random_;
  std::vector<Taken> leaves_;  ///< open doors
  std::vector<Taken> taken_;   ///< by furniture
  std::vector<Taken> rugs_;
  std::vector<Taken> kept_free_;  ///< before doors
  std::vector<Vector3> doorsteps_;
};

/// @return the rectangle around a turned piece
FloorRectangle footprint_of(const Vector3& size_m, const Placement& placement);

/// Furnishes a room by its kind.
/// @param furnishing, softness  as in HomeOptions
void furnish_room(RoomFurnisher& furnisher, double furnishing, double softness);

}  // namespace earpoint

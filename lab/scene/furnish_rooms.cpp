#include "room_furnisher.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

using enum FurnitureKind;

constexpr double kAnyHeight_m = 2.25;

/// Furnishes one room. `full` is the share of possible furniture that is placed.
class RoomRecipe {
 public:
  RoomRecipe(RoomFurnisher& furnisher, double full, double soft)
      : furnisher_(furnisher), full_(full), soft_(soft) {}

  void follow() {
    dress_windows();
    switch (furnisher_.room().kind) {
      case RoomKind::living_room:
        live();
        break;
      case RoomKind::bedroom:
        sleep();
        break;
      case RoomKind::kitchen:
        cook();
        break;
      case RoomKind::bathroom:
        wash();
        break;
      case RoomKind::office:
        work();
        break;
      case RoomKind::corridor:
        pass();
        break;
    }
    hang_pictures();
    hang_lamp();
  }

 private:
  [[nodiscard]] double area_m2() const { return furnisher_.room().floor.area_m2(); }
  [[nodiscard]] double shorter_m() const {
    return std::min(furnisher_.room().floor.width_m(), furnisher_.room().floor.depth_m());
  }
  /// Rugs are more frequent on hard floors than on carpets.
  [[nodiscard]] double rug_share() const { return full_ > 0.0 ? 0.95 - 0.6 * soft_ : 0.0; }
  bool likely(double share) { return furnisher_.chance(share * full_); }

  void live();
  void sleep();
  void cook();
  void wash();
  void work();
  void pass();
  void eat();
  void dress_windows();
  void dress(const HomeWindow& window);
  void hang_pictures();
  void hang_lamp();
  void fill_walls(std::initializer_list<FurnitureKind> kinds, double most_depth_m, int most);
  /// The place of a unit in a row.
  struct RowSpot {
    PlacedFurniture piece;
    double along_m;  ///< of its middle
    double next_m;   ///< first position of the next unit
  };
  std::optional<RowSpot> slide_in(const FurniturePiece& piece, Side side, bool backwards,
                                  double at_m);
  void stand_in_row(Side side, bool backwards);

  RoomFurnisher& furnisher_;
  double full_;
  double soft_;
};

void RoomRecipe::live() {
  const double longest_m = std::min(2.9, 0.75 * shorter_m());
  const auto sofa_piece =
      furnisher_.place_at_wall(sofa, {1.1, longest_m, 1.1}, std::min(0.9, 0.25 * shorter_m()));
  if (sofa_piece) {
    if (furnisher_.chance(rug_share())) {
      furnisher_.place_before(rug, *sofa_piece, {2.0, 2.9, 0.02}, 0.1, false);
    }
    if (likely(1.1))
      furnisher_.place_before(coffee_table, *sofa_piece, {0.8, 1.3, 0.6}, 0.4, false);
    if (likely(1.0)) {
      const auto stand = furnisher_.place_before(tv_stand, *sofa_piece, {0.55, 1.7, 0.7},
                                                 std::max(1.4, shorter_m() - 1.9), true);
      const auto base = stand ? stand : furnisher_.place_at_wall(tv_stand, {0.55, 1.7, 0.7}, 0.5);
      if (base) furnisher_.place_on(television, *base);
    }
  }
  if (area_m2() > 16.0 && likely(0.8)) furnisher_.place_at_wall(sofa, {1.1, 2.0, 1.1}, 0.6);
  const int armchairs = likely(0.8) ? 1 + (likely(0.5) ? 1 : 0) : 0;
  for (int i = 0; i < armchairs; ++i) furnisher_.place_at_wall(armchair, {1.0, 1.1, 1.2}, 0.5);
  if (area_m2() > 18.0 && likely(0.8)) eat();
  if (likely(0.12)) furnisher_.place_at_wall(piano, {1.0, 1.6, 1.5}, 0.6);
  fill_walls({bookcase, shelf, dresser, bookcase}, 0.6, 1 + static_cast<int>(area_m2() / 9.0));
  if (likely(0.7)) furnisher_.place_at_wall(floor_lamp, {0.6, 0.6, 1.9}, 0.0);
  for (int i = 0; i < 2; ++i) {
    if (likely(0.5)) furnisher_.place_at_wall(plant, {0.8, 0.8, 1.9}, 0.0);
  }
}

void RoomRecipe::sleep() {
  const bool wide = shorter_m() > 2.7;
  const auto bed_piece = furnisher_.place_at_wall(bed, {2.4, wide ? 2.1 : 1.3, 1.3}, 0.4);
  if (bed_piece) {
    const Side side = RoomFurnisher::side_behind(*bed_piece);
    const bool upright = side == Side::x_low || side == Side::x_high;
    const double low = upright ? bed_piece->footprint.y_min : bed_piece->footprint.x_min;
    const double high = upright ? bed_piece->footprint.y_max : bed_piece->footprint.x_max;
    for (const bool above : {false, true}) {
      const auto table = furnisher_.draw(bedside_table, {0.55, 0.6, 0.7});
      if (!table || !likely(1.2)) continue;
      const double half = table->size_m.y / 2.0 + 0.03;
      const auto beside = furnisher_.place_at(
          *table, {.side = side, .along_m = above ? high + half : low - half}, 0.0);
      if (beside && likely(0.7)) furnisher_.place_on(table_lamp, *beside);
    }
    if (furnisher_.chance(0.9 * rug_share())) {
      furnisher_.place_before(rug, *bed_piece, {1.4, 2.2, 0.02}, -0.6, false);
    }
  }
  if (likely(1.3)) furnisher_.place_at_wall(wardrobe, {0.75, 2.4, kAnyHeight_m}, 0.5);
  fill_walls({dresser, shelf, bookcase}, 0.6, 1 + static_cast<int>(area_m2() / 12.0));
  if (likely(0.5)) {
    const auto table = furnisher_.place_at_wall(desk, {0.8, 1.5, 1.2}, 0.6);
    if (table) furnisher_.place_before(chair, *table, {0.65, 0.65, 1.1}, 0.04, true);
  }
  if (likely(0.4)) furnisher_.place_at_wall(armchair, {0.9, 1.0, 1.2}, 0.4);
  if (likely(0.4)) furnisher_.place_at_wall(plant, {0.6, 0.6, 1.6}, 0.0);
}

/// A table on the free floor with chairs at its sides.
void RoomRecipe::eat() {
  const auto table = furnisher_.draw(dining_table, {1.2, std::min(2.0, 0.5 * shorter_m()), 0.95});
  if (!table) return;
  const FloorRectangle inner = grown(furnisher_.room().floor, -1.0);
  if (inner.width_m() <= 0.0 || inner.depth_m() <= 0.0) return;
  RandomStream& random = furnisher_.random();
  std::optional<PlacedFurniture> stands;
  for (int i = 0; i < 30 && !stands; ++i) {
    Placement placement;
    placement.position_m = {random.uniform(inner.x_min, inner.x_max),
                            random.uniform(inner.y_min, inner.y_max), 0.0};
    placement.yaw_rad = random.uniform() < 0.5 ? 0.0 : kPi / 2;
    stands = furnisher_.place(*table, placement);
  }
  if (!stands) return;
  if (furnisher_.chance(0.6 * rug_share())) {
    const auto under = furnisher_.draw(rug, {table->size_m.x + 1.3, table->size_m.y + 1.3, 0.02});
    const Vector3 middle{stands->footprint.centre_x(), stands->footprint.centre_y(), 0.0};
    if (under) furnisher_.place(*under, {.position_m = middle, .yaw_rad = stands->yaw_rad}, false);
  }
  const auto seat = furnisher_.draw(chair, {0.65, 0.65, 1.1});
  if (!seat) return;
  const int per_side = table->size_m.y > 1.25 ? 2 : 1;
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i < per_side; ++i) {
      if (!likely(1.2)) continue;
      const double along = table->size_m.y * ((i + 0.5) / per_side - 0.5);
      const double turn = random.uniform(-0.15, 0.15);
      const double reach = table->size_m.x / 2.0 + seat->size_m.x / 2.0 + 0.09;
      Placement placement;
      placement.position_m =
          placed({.position_m = {stands->footprint.centre_x(), stands->footprint.centre_y(), 0.0},
                  .yaw_rad = stands->yaw_rad},
                 {side * reach, along, 0.0});
      placement.yaw_rad = stands->yaw_rad + (side > 0.0 ? kPi : 0.0) + turn;
      furnisher_.place(*seat, placement);
    }
  }
}

/// Slides a unit along a wall from `at_m` until it fits between doors and windows.
std::optional<RoomRecipe::RowSpot> RoomRecipe::slide_in(const FurniturePiece& piece, Side side,
                                                        bool backwards, double at_m) {
  const FloorRectangle& floor = furnisher_.room().floor;
  const bool upright = side == Side::x_low || side == Side::x_high;
  const double first = upright ? floor.y_min : floor.x_min;
  const double last = upright ? floor.y_max : floor.x_max;
  for (double at = at_m; at + piece.size_m.y <= last - first - 0.03; at += 0.1) {
    const double middle = at + piece.size_m.y / 2.0;
    const double along = backwards ? last - middle : first + middle;
    const auto stands =
        furnisher_.place_at(piece, {.side = side, .along_m = along, .gap_m = 0.01}, 0.5);
    if (stands) return RowSpot{*stands, along, at + piece.size_m.y + 0.006};
  }
  return std::nullopt;
}

/// Units side by side along a wall, cabinets above them.
void RoomRecipe::stand_in_row(Side side, bool backwards) {
  const std::array<FurnitureKind, 7> units = {fridge, kitchen_base, kitchen_sink, kitchen_base,
                                              stove,  kitchen_base, kitchen_base};
  double at = 0.03;
  for (const FurnitureKind kind : units) {
    if (kind == kitchen_base && !likely(1.6)) continue;
    const auto piece = furnisher_.draw(kind, {1.0, 1.2, kAnyHeight_m});
    if (!piece) continue;
    const auto stands = slide_in(*piece, side, backwards, at);
    if (!stands) continue;
    at = stands->next_m;
    if (stands->piece.z_high_m > 1.3 || !likely(0.8)) continue;
    const auto above = furnisher_.draw(wall_cabinet, {0.42, piece->size_m.y, 0.8});
    const double base_m = 1.45;
    if (!above || base_m + above->size_m.z > furnisher_.room().ceiling_m) continue;
    furnisher_.place_at(
        *above, {.side = side, .along_m = stands->along_m, .gap_m = 0.01, .base_m = base_m}, 0.0);
  }
}

void RoomRecipe::cook() {
  std::array<Side, 4> sides = {Side::x_low, Side::x_high, Side::y_low, Side::y_high};
  RandomStream& random = furnisher_.random();
  // One of the two longest walls.
  std::stable_sort(sides.begin(), sides.end(), [&](Side a, Side b) {
    return furnisher_.wall_length_m(a) > furnisher_.wall_length_m(b);
  });
  stand_in_row(sides[random.index(2)], random.uniform() < 0.5);
  if (area_m2() > 8.0 && likely(1.0)) eat();
  fill_walls({shelf, dresser, bookcase}, 0.5, static_cast<int>(area_m2() / 7.0));
  if (likely(0.3)) furnisher_.place_at_wall(plant, {0.5, 0.5, 1.2}, 0.0);
}

void RoomRecipe::wash() {
  furnisher_.place_at_wall(toilet, {0.8, 0.5, 1.0}, 0.35);
  const auto basin = furnisher_.place_at_wall(washbasin, {0.6, 1.0, 1.0}, 0.4);
  if (basin) {
    const Side side = RoomFurnisher::side_behind(*basin);
    const bool upright = side == Side::x_low || side == Side::x_high;
    const auto glass = furnisher_.draw(mirror, {0.1, 0.9, 0.9});
    if (glass) {
      furnisher_.place_at(
          *glass,
          {.side = side,
           .along_m = upright ? basin->footprint.centre_y() : basin->footprint.centre_x(),
           .gap_m = 0.01,
           .base_m = 1.1},
          0.0);
    }
  }
  if (likely(1.3)) {
    furnisher_.place_at_wall(bathtub, {0.95, 1.85, 1.1}, 0.3);
  }
  if (likely(0.7)) furnisher_.place_at_wall(washing_machine, {0.7, 0.7, 1.0}, 0.4);
  if (furnisher_.chance(0.3 + 0.6 * soft_)) {
    furnisher_.place_at_wall(towel_rack, {0.3, 0.7, 1.2}, 0.0, 0.8);
  }
}

void RoomRecipe::work() {
  const int desks = area_m2() > 12.0 && likely(0.7) ? 2 : 1;
  for (int i = 0; i < desks; ++i) {
    const auto table = furnisher_.place_at_wall(desk, {0.95, 1.9, 1.3}, 0.7);
    if (!table) continue;
    if (table->z_high_m < 0.85) furnisher_.place_on(computer, *table);
    furnisher_.place_before(office_chair, *table, {0.75, 0.75, 1.2}, 0.05, true);
  }
  fill_walls({bookcase, shelf, bookcase, dresser}, 0.6, 1 + static_cast<int>(area_m2() / 6.0));
  if (likely(0.5)) furnisher_.place_at_wall(armchair, {1.0, 1.0, 1.2}, 0.4);
  if (area_m2() > 13.0 && likely(0.4)) furnisher_.place_at_wall(sofa, {1.0, 2.0, 1.1}, 0.6);
  if (furnisher_.chance(0.7 * rug_share())) furnisher_.place_at_wall(rug, {2.0, 2.6, 0.02}, 0.0);
  if (likely(0.5)) furnisher_.place_at_wall(plant, {0.7, 0.7, 1.8}, 0.0);
  if (likely(0.4)) furnisher_.place_at_wall(floor_lamp, {0.6, 0.6, 1.9}, 0.0);
}

void RoomRecipe::pass() {
  if (furnisher_.chance(rug_share())) {
    furnisher_.place_at_wall(rug, {0.75 * shorter_m(), 3.0, 0.02}, 0.0);
  }
  if (likely(0.8)) furnisher_.place_at_wall(towel_rack, {0.3, 0.7, 1.2}, 0.0, 0.9);
  if (likely(0.5)) furnisher_.place_at_wall(shelf, {0.36, 1.0, 1.4}, 0.0);
  if (likely(0.5)) furnisher_.place_at_wall(mirror, {0.1, 0.7, 1.2}, 0.0, 0.9);
  if (likely(0.3)) furnisher_.place_at_wall(plant, {0.45, 0.45, 1.2}, 0.0);
}

void RoomRecipe::fill_walls(std::initializer_list<FurnitureKind> kinds, double most_depth_m,
                            int most) {
  for (int i = 0; i < most; ++i) {
    if (!likely(0.75)) continue;
    const auto kind = kinds.begin()[furnisher_.random().index(kinds.size())];
    furnisher_.place_at_wall(kind, {most_depth_m, 1.9, kAnyHeight_m}, 0.4);
  }
}

void RoomRecipe::dress(const HomeWindow& window) {
  RandomStream& random = furnisher_.random();
  const bool upright = window.side == Side::x_low || window.side == Side::x_high;
  const double low = upright ? window.recess.y_min : window.recess.x_min;
  const double high = upright ? window.recess.y_max : window.recess.x_max;
  const double width = high - low;
  const double top = std::min(window.head_m + 0.12, furnisher_.room().ceiling_m - 0.03);
  const auto hang = [&](FurnitureKind kind, double middle, double across, double bottom,
                        double depth) {
    const FurniturePiece piece{
        .kind = kind, .model = nullptr, .size_m = {depth, across, top - bottom}};
    furnisher_.place_at(
        piece, {.side = window.side, .along_m = middle, .gap_m = 0.05, .base_m = bottom}, 0.0);
  };
  const bool wet =
      furnisher_.room().kind == RoomKind::bathroom || furnisher_.room().kind == RoomKind::kitchen;
  const double draw = random.uniform();
  if (draw > 0.5 + 0.4 * soft_ + 0.2 * full_) return;
  const double bottom = random.uniform() < 0.6 && !wet ? 0.03 : window.sill_m - 0.12;
  if (wet || random.uniform() < 0.2) {
    if (random.uniform() < 0.6)
      hang(blinds, (low + high) / 2, width + 0.06, window.sill_m - 0.05, 0.04);
    return;
  }
  if (random.uniform() < 0.2 + 0.5 * soft_) {
    hang(curtain, (low + high) / 2, width + 0.5, bottom, 0.1);
    return;
  }
  const double panel = std::clamp(random.uniform(0.2, 0.4) * width, 0.25, 0.7);
  hang(curtain, low - 0.1 + panel / 2, panel, bottom, 0.1);
  hang(curtain, high + 0.1 - panel / 2, panel, bottom, 0.1);
}

void RoomRecipe::dress_windows() {
  for (const HomeWindow* window : furnisher_.windows()) {
    dress(*window);
    if (window->sill_m < 0.7 || !likely(0.5)) continue;
    const double width_m =
        std::min(1.2, 0.8 * std::max(window->recess.width_m(), window->recess.depth_m()));
    const auto heater = furnisher_.draw(radiator, {0.14, width_m, window->sill_m - 0.12});
    const bool upright = window->side == Side::x_low || window->side == Side::x_high;
    if (!heater) continue;
    furnisher_.place_at(*heater,
                        {.side = window->side,
                         .along_m = upright ? window->recess.centre_y() : window->recess.centre_x(),
                         .gap_m = 0.02,
                         .base_m = 0.1},
                        0.0);
  }
}

void RoomRecipe::hang_pictures() {
  const RoomKind kind = furnisher_.room().kind;
  if (kind == RoomKind::bathroom) return;
  const int most = 1 + static_cast<int>(area_m2() / 6.0);
  for (int i = 0; i < most; ++i) {
    if (likely(0.7)) furnisher_.place_at_wall(picture, {0.08, 1.2, 0.8}, 0.0, 1.35);
  }
}

void RoomRecipe::hang_lamp() {
  const FloorRectangle& floor = furnisher_.room().floor;
  const double ceiling_m = furnisher_.room().ceiling_m;
  const auto lamp = furnisher_.draw(ceiling_lamp, {0.6, 0.6, ceiling_m - 2.1});
  if (!lamp) return;
  Placement placement;
  placement.position_m = {floor.centre_x(), floor.centre_y(), ceiling_m - lamp->size_m.z - 0.004};
  furnisher_.place(*lamp, placement, false);
}

}  // namespace

void furnish_room(RoomFurnisher& furnisher, double furnishing, double softness) {
  RoomRecipe(furnisher, furnishing, softness).follow();
}

}  // namespace earpoint

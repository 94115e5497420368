#include <earpoint/scene/floor_plan.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/core.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kMostRooms = 6;
constexpr int kAttempts = 4000;

/// The range of total areas for 1 to 6 rooms, m2.
constexpr std::array<std::pair<double, double>, kMostRooms> kAreas_m2 = {
    {{20, 45}, {28, 60}, {38, 80}, {50, 105}, {65, 130}, {80, 150}}};

struct RoomShape {
  double weight;      ///< of its area, relative to the other rooms
  double shortest_m;  ///< side
};

RoomShape shape_of(RoomKind kind) {
  switch (kind) {
    case RoomKind::living_room:
      return {2.2, 2.9};
    case RoomKind::bedroom:
      return {1.3, 2.5};
    case RoomKind::kitchen:
      return {1.0, 2.0};
    case RoomKind::bathroom:
      return {0.5, 1.6};
    case RoomKind::office:
      return {1.0, 2.2};
    case RoomKind::corridor:
      return {0.4, 1.0};
  }
  return {1.0, 2.0};
}

double snapped(double metres) { return std::round(metres * 100.0) / 100.0; }

template <typename T>
void shuffle(std::vector<T>& items, RandomStream& random) {
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random.index(i)]);
}

struct Wish {
  RoomKind kind;
  double weight;
};

std::vector<Wish> draw_wishes(int rooms, RandomStream& random) {
  using enum RoomKind;
  const auto either = [&](RoomKind a, RoomKind b) { return random.uniform() < 0.5 ? a : b; };
  std::vector<RoomKind> kinds;
  switch (rooms) {
    case 1: {
      constexpr std::array<RoomKind, 6> kSingle = {living_room, living_room, living_room,
                                                   bedroom,     bedroom,     office};
      kinds = {kSingle[random.index(kSingle.size())]};
      break;
    }
    case 2:
      kinds = {living_room, either(bedroom, either(kitchen, bathroom))};
      break;
    case 3:
      kinds = {living_room, bedroom, either(kitchen, bathroom)};
      break;
    case 4:
      kinds = {living_room, bedroom, kitchen, either(bathroom, office)};
      break;
    case 5:
      kinds = {living_room, bedroom, kitchen, bathroom, either(bedroom, office)};
      break;
    default:
      kinds = {living_room, bedroom, kitchen, bathroom, bedroom, office};
      break;
  }
  std::vector<Wish> wishes;
  wishes.reserve(kinds.size());
  for (const RoomKind kind : kinds) {
    wishes.push_back({kind, shape_of(kind).weight * random.uniform(0.8, 1.25)});
  }
  shuffle(wishes, random);
  return wishes;
}

double total_weight(const std::vector<Wish>& wishes) {
  double sum = 0.0;
  for (const Wish& wish : wishes) sum += wish.weight;
  return sum;
}

bool fits(const Room& room) {
  const double shorter = std::min(room.floor.width_m(), room.floor.depth_m());
  const double longer = std::max(room.floor.width_m(), room.floor.depth_m());
  if (shorter < shape_of(room.kind).shortest_m) return false;
  return room.kind == RoomKind::corridor || longer <= 2.4 * shorter;
}

/// Divides a rectangle repeatedly, always across its longer side.
void split(const FloorRectangle& floor, std::vector<Wish> wishes, double wall_m,
           std::vector<Room>& rooms) {
  if (wishes.size() == 1) {
    rooms.push_back({.kind = wishes[0].kind, .floor = floor, .ceiling_m = 0.0});
    return;
  }
  // Cuts the list where the weights of the two sides are most equal.
  const double total = total_weight(wishes);
  std::size_t cut = 1;
  double below = wishes[0].weight;
  while (cut + 1 < wishes.size() && below + wishes[cut].weight / 2.0 < total / 2.0) {
    below += wishes[cut++].weight;
  }
  std::vector<Wish> rest(wishes.begin() + static_cast<std::ptrdiff_t>(cut), wishes.end());
  wishes.resize(cut);
  FloorRectangle low = floor;
  FloorRectangle high = floor;
  if (floor.width_m() >= floor.depth_m()) {
    low.x_max = snapped(floor.x_min + (floor.width_m() - wall_m) * below / total);
    high.x_min = snapped(low.x_max + wall_m);
  } else {
    low.y_max = snapped(floor.y_min + (floor.depth_m() - wall_m) * below / total);
    high.y_min = snapped(low.y_max + wall_m);
  }
  split(low, std::move(wishes), wall_m, rooms);
  split(high, std::move(rest), wall_m, rooms);
}

/// Adds rooms of the same depth, side by side along x.
void add_row(const std::vector<Wish>& wishes, double length_m, double y_min, double y_max,
             double wall_m, std::vector<Room>& rooms) {
  const double free_m = length_m - wall_m * static_cast<double>(wishes.size() - 1);
  const double total = total_weight(wishes);
  double x = 0.0;
  for (std::size_t i = 0; i < wishes.size(); ++i) {
    const bool last = i + 1 == wishes.size();
    const double x_max = last ? length_m : snapped(x + free_m * wishes[i].weight / total);
    rooms.push_back({.kind = wishes[i].kind, .floor = {x, y_min, x_max, y_max}, .ceiling_m = 0.0});
    x = snapped(x_max + wall_m);
  }
}

/// A corridor along x with a row of rooms on each side.
std::vector<Room> lay_out_along_corridor(std::vector<Wish> wishes, double area_m2, double wall_m,
                                         RandomStream& random) {
  const double length_m = snapped(std::sqrt(area_m2 * random.uniform(0.9, 2.2)));
  const double corridor_m = snapped(random.uniform(1.0, 1.6));
  const auto half =
      static_cast<std::ptrdiff_t>(wishes.size() / 2 + random.index(2) * (wishes.size() % 2));
  const std::vector<Wish> low(wishes.begin(), wishes.begin() + half);
  const std::vector<Wish> high(wishes.begin() + half, wishes.end());
  if (low.empty() || high.empty()) return {};
  const double depth_m = area_m2 / length_m - corridor_m;
  const double share = total_weight(low) / total_weight(wishes);
  std::vector<Room> rooms;
  const double low_top = snapped(depth_m * share);
  add_row(low, length_m, 0.0, low_top, wall_m, rooms);
  const double corridor_low = snapped(low_top + wall_m);
  const double corridor_high = snapped(corridor_low + corridor_m);
  rooms.push_back({.kind = RoomKind::corridor,
                   .floor = {0.0, corridor_low, length_m, corridor_high},
                   .ceiling_m = 0.0});
  const double high_low = snapped(corridor_high + wall_m);
  add_row(high, length_m, high_low, snapped(high_low + depth_m * (1.0 - share)), wall_m, rooms);
  return rooms;
}

std::vector<Room> lay_out(const std::vector<Wish>& wishes, double area_m2, double wall_m,
                          RandomStream& random) {
  if (wishes.size() >= 3 && random.uniform() < 0.6) {
    return lay_out_along_corridor(wishes, area_m2, wall_m, random);
  }
  const double width_m = snapped(std::sqrt(area_m2 * random.uniform(1.0, 1.9)));
  std::vector<Room> rooms;
  split({0.0, 0.0, width_m, snapped(area_m2 / width_m)}, wishes, wall_m, rooms);
  return rooms;
}

void transpose(std::vector<Room>& rooms) {
  for (Room& room : rooms) {
    std::swap(room.floor.x_min, room.floor.y_min);
    std::swap(room.floor.x_max, room.floor.y_max);
  }
}

void set_ceilings(std::vector<Room>& rooms, double ceiling_m, RandomStream& random) {
  for (Room& room : rooms) {
    room.ceiling_m = snapped(ceiling_m);
    // Baths and corridors often have a lowered ceiling.
    const bool may_be_low = room.kind == RoomKind::bathroom || room.kind == RoomKind::corridor;
    if (may_be_low && rooms.size() > 1 && random.uniform() < 0.4) {
      room.ceiling_m = snapped(std::max(2.3, ceiling_m - random.uniform(0.1, 0.5)));
    }
  }
}

void check_range(const char* field, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw InputError(fmt::format("home: {}", field),
                   fmt::format("expected {} to {}, found {}", low, high, value));
}

}  // namespace

std::string_view name_of(RoomKind kind) {
  switch (kind) {
    case RoomKind::living_room:
      return "living room";
    case RoomKind::bedroom:
      return "bedroom";
    case RoomKind::kitchen:
      return "kitchen";
    case RoomKind::bathroom:
      return "bathroom";
    case RoomKind::office:
      return "office";
    case RoomKind::corridor:
      return "corridor";
  }
  return "room";
}

double FloorPlan::area_m2() const {
  double sum = 0.0;
  for (const Room& room : rooms) sum += room.floor.area_m2();
  return sum;
}

FloorRectangle FloorPlan::footprint() const {
  FloorRectangle around = rooms.empty() ? FloorRectangle{} : rooms[0].floor;
  for (const Room& room : rooms) {
    around.x_min = std::min(around.x_min, room.floor.x_min);
    around.y_min = std::min(around.y_min, room.floor.y_min);
    around.x_max = std::max(around.x_max, room.floor.x_max);
    around.y_max = std::max(around.y_max, room.floor.y_max);
  }
  return around;
}

FloorPlan draw_floor_plan(const PlanOptions& options, RandomStream& random) {
  if (options.rooms) check_range("rooms", *options.rooms, 1, kMostRooms);
  if (options.area_m2) check_range("area_m2", *options.area_m2, 20.0, 150.0);
  if (options.ceiling_m) check_range("ceiling_m", *options.ceiling_m, 2.3, 3.2);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const int count = options.rooms.value_or(1 + static_cast<int>(random.index(kMostRooms)));
    const auto [low_m2, high_m2] = kAreas_m2[static_cast<std::size_t>(count - 1)];
    const double drawn_m2 = random.uniform(low_m2, high_m2);
    const double area_m2 = options.area_m2.value_or(drawn_m2);
    if (!options.rooms && (area_m2 < low_m2 || area_m2 > high_m2)) continue;
    FloorPlan plan;
    plan.inner_wall_m = snapped(random.uniform(0.09, 0.17));
    plan.rooms = lay_out(draw_wishes(count, random), area_m2, plan.inner_wall_m, random);
    // Walls and rounding to centimetres make the sum a little smaller than requested.
    const double sum_m2 = plan.area_m2();
    const bool right_size = sum_m2 >= std::max(20.0, 0.9 * area_m2) && sum_m2 <= 150.0;
    if (!right_size || !std::all_of(plan.rooms.begin(), plan.rooms.end(), fits)) continue;
    if (random.uniform() < 0.5) transpose(plan.rooms);
    set_ceilings(plan.rooms, options.ceiling_m.value_or(random.uniform(2.3, 3.2)), random);
    if (add_openings(plan, random)) return plan;
  }
  throw InputError("home",
                   fmt::format("{} rooms do not fit {} m2", options.rooms.value_or(kMostRooms),
                               options.area_m2.value_or(0.0)),
                   "use fewer rooms or another area");
}

}  // namespace earpoint

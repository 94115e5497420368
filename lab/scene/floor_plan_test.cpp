#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/scene/floor_plan.h>

namespace earpoint {
namespace {

constexpr int kPlans = 200;

std::vector<FloorPlan> many_plans() {
  std::vector<FloorPlan> plans;
  for (int seed = 0; seed < kPlans; ++seed) {
    RandomStream random(static_cast<std::uint64_t>(seed));
    plans.push_back(draw_floor_plan({}, random));
  }
  return plans;
}

int rooms_without_corridor(const FloorPlan& plan) {
  return static_cast<int>(std::count_if(plan.rooms.begin(), plan.rooms.end(), [](const Room& room) {
    return room.kind != RoomKind::corridor;
  }));
}

TEST(FloorPlan, StaysInTheStatedRangesAndReachesTheirEnds) {
  std::set<int> counts;
  double smallest_m2 = 1e9;
  double largest_m2 = 0.0;
  double lowest_m = 1e9;
  double highest_m = 0.0;
  bool corridor = false;
  for (const FloorPlan& plan : many_plans()) {
    counts.insert(rooms_without_corridor(plan));
    smallest_m2 = std::min(smallest_m2, plan.area_m2());
    largest_m2 = std::max(largest_m2, plan.area_m2());
    for (const Room& room : plan.rooms) {
      lowest_m = std::min(lowest_m, room.ceiling_m);
      highest_m = std::max(highest_m, room.ceiling_m);
      corridor = corridor || room.kind == RoomKind::corridor;
    }
  }
  EXPECT_EQ(counts, (std::set<int>{1, 2, 3, 4, 5, 6}));
  EXPECT_GE(smallest_m2, 20.0);
  EXPECT_LE(smallest_m2, 28.0);
  EXPECT_LE(largest_m2, 150.0);
  EXPECT_GE(largest_m2, 120.0);
  EXPECT_GE(lowest_m, 2.3);
  EXPECT_LE(highest_m, 3.2);
  EXPECT_GT(highest_m - lowest_m, 0.8);
  EXPECT_TRUE(corridor);
}

TEST(FloorPlan, KeepsRoomsApartByTheirWalls) {
  for (const FloorPlan& plan : many_plans()) {
    for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
      for (std::size_t j = i + 1; j < plan.rooms.size(); ++j) {
        // A hundredth of a millimetre for rounding, as centimetres are not exact in binary.
        EXPECT_FALSE(
            overlap(grown(plan.rooms[i].floor, plan.inner_wall_m - 1e-5), plan.rooms[j].floor));
      }
    }
  }
}

TEST(FloorPlan, JoinsEveryRoomToEveryOther) {
  for (const FloorPlan& plan : many_plans()) {
    std::set<int> reached = {0};
    for (std::size_t round = 0; round < plan.rooms.size(); ++round) {
      for (const Door& door : plan.doors) {
        if (door.room_b == Door::kOutside) continue;
        if (reached.contains(door.room_a)) reached.insert(door.room_b);
        if (reached.contains(door.room_b)) reached.insert(door.room_a);
      }
    }
    EXPECT_EQ(reached.size(), plan.rooms.size());
  }
}

TEST(FloorPlan, HasOneFrontDoorAndAllKindsOfDoorsInside) {
  std::set<DoorState> states;
  for (const FloorPlan& plan : many_plans()) {
    const auto outside = std::count_if(plan.doors.begin(), plan.doors.end(), [](const Door& door) {
      return door.room_b == Door::kOutside;
    });
    EXPECT_EQ(outside, 1);
    for (const Door& door : plan.doors) states.insert(door.state);
  }
  EXPECT_EQ(states.size(), 3U);
}

TEST(FloorPlan, KeepsOpeningsApartAndBelowTheCeiling) {
  for (const FloorPlan& plan : many_plans()) {
    std::vector<FloorRectangle> holes;
    for (const Door& door : plan.doors) {
      holes.push_back(door.opening);
      EXPECT_LT(door.height_m, plan.rooms[static_cast<std::size_t>(door.room_a)].ceiling_m);
      EXPECT_GE(std::max(door.opening.width_m(), door.opening.depth_m()), 0.7);
    }
    for (const HomeWindow& window : plan.windows) {
      holes.push_back(window.recess);
      EXPECT_LT(window.sill_m, window.head_m);
      EXPECT_LT(window.head_m, plan.rooms[static_cast<std::size_t>(window.room)].ceiling_m);
    }
    for (std::size_t i = 0; i < holes.size(); ++i) {
      for (const Room& room : plan.rooms) EXPECT_FALSE(overlap(grown(holes[i], -1e-6), room.floor));
      for (std::size_t j = i + 1; j < holes.size(); ++j) {
        EXPECT_FALSE(overlap(grown(holes[i], 0.01), holes[j]));
      }
    }
  }
}

TEST(FloorPlan, HangsOpenLeavesInsideTheirRoomClearOfOtherDoors) {
  int leaves = 0;
  for (const FloorPlan& plan : many_plans()) {
    for (const Door& door : plan.doors) {
      const FloorRectangle leaf = leaf_footprint(plan, door);
      if (door.state != DoorState::open) {
        EXPECT_EQ(leaf, FloorRectangle{});
        continue;
      }
      ++leaves;
      const FloorRectangle& floor = plan.rooms[static_cast<std::size_t>(door.room_a)].floor;
      EXPECT_TRUE(floor.contains(leaf.x_min, leaf.y_min) && floor.contains(leaf.x_max, leaf.y_max));
      for (const Door& other : plan.doors) {
        if (&other == &door) continue;
        EXPECT_FALSE(overlap(leaf, grown(other.opening, 0.3)));
        EXPECT_FALSE(overlap(leaf, leaf_footprint(plan, other)));
      }
    }
  }
  EXPECT_GT(leaves, 100);
}

TEST(FloorPlan, FollowsItsOptions) {
  for (int seed = 0; seed < 20; ++seed) {
    RandomStream random(static_cast<std::uint64_t>(seed));
    const FloorPlan plan = draw_floor_plan({.rooms = 4, .area_m2 = 80.0, .ceiling_m = 2.6}, random);
    EXPECT_EQ(rooms_without_corridor(plan), 4);
    // Walls take up to a tenth.
    EXPECT_NEAR(plan.area_m2(), 80.0, 8.0);
    EXPECT_TRUE(std::any_of(plan.rooms.begin(), plan.rooms.end(),
                            [](const Room& room) { return room.ceiling_m == 2.6; }));
  }
}

std::string refusal(const PlanOptions& options) {
  RandomStream random(1);
  try {
    draw_floor_plan(options, random);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(FloorPlan, RefusesWhatNoHomeCanBe) {
  EXPECT_EQ(refusal({.rooms = 7}), "home: rooms: expected 1 to 6, found 7");
  EXPECT_EQ(refusal({.area_m2 = 10.0}), "home: area_m2: expected 20 to 150, found 10");
  EXPECT_EQ(refusal({.ceiling_m = 4.0}), "home: ceiling_m: expected 2.3 to 3.2, found 4");
  EXPECT_EQ(refusal({.rooms = 6, .area_m2 = 20.0}),
            "home: 6 rooms do not fit 20 m2; use fewer rooms or another area");
}

}  // namespace
}  // namespace earpoint

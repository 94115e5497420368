#include "conversation_views.h"

#include <array>
#include <cmath>
#include <optional>

#include <earpoint/error.h>

namespace earpoint::bench {
namespace {

constexpr double kBody_m = 0.3;
constexpr double kNearest_m = 0.8;
constexpr double kFarthest_m = 3.0;
constexpr double kCameraHeight_m = 1.5;
constexpr double kNearestCamera_m = 1.2;
constexpr double kFarthestCamera_m = 4.5;
constexpr int kTries = 4000;

struct Spot {
  double x = 0.0;
  double y = 0.0;
};

double distance_m(const Spot& a, const Spot& b) { return std::hypot(a.x - b.x, a.y - b.y); }

Spot draw_spot(const FloorRectangle& floor, RandomStream& random) {
  const double x = random.uniform(floor.x_min, floor.x_max);
  return {x, random.uniform(floor.y_min, floor.y_max)};
}

/// The positions of the two people.
std::optional<std::array<Spot, 2>> draw_places(const Home& home, RandomStream& random) {
  for (int i = 0; i < kTries; ++i) {
    const auto room = random.index(home.plan.rooms.size());
    const FloorRectangle& floor = home.plan.rooms[room].floor;
    const Spot a = draw_spot(floor, random);
    const Spot b = draw_spot(floor, random);
    const double apart_m = distance_m(a, b);
    if (apart_m < kNearest_m || apart_m > kFarthest_m) continue;
    if (is_free(home, a.x, a.y, kBody_m) && is_free(home, b.x, b.y, kBody_m)) {
      return std::array<Spot, 2>{a, b};
    }
  }
  return std::nullopt;
}

Posture draw_posture(RandomStream& random) {
  const double draw = random.uniform();
  return draw < 0.7 ? Posture::standing : draw < 0.95 ? Posture::sitting : Posture::ground;
}

std::optional<Spot> draw_camera_place(const Home& home, const std::array<Spot, 2>& people,
                                      RandomStream& random) {
  const Spot middle{(people[0].x + people[1].x) / 2.0, (people[0].y + people[1].y) / 2.0};
  const int room = room_at(home.plan, people[0].x, people[0].y);
  const FloorRectangle& floor = home.plan.rooms[static_cast<std::size_t>(room)].floor;
  for (int i = 0; i < kTries; ++i) {
    const Spot spot = draw_spot(floor, random);
    const double away_m = distance_m(spot, middle);
    if (away_m < kNearestCamera_m || away_m > kFarthestCamera_m) continue;
    if (distance_m(spot, people[0]) < 0.8 || distance_m(spot, people[1]) < 0.8) continue;
    if (is_free(home, spot.x, spot.y, 0.2)) return spot;
  }
  return std::nullopt;
}

}  // namespace

ConversationViews draw_conversation(const Home& home, const FigureLibrary& figures, int views,
                                    int width, int height, RandomStream& random) {
  for (int attempt = 0; attempt < 20; ++attempt) {
    const auto places = draw_places(home, random);
    if (!places) break;
    const auto& [a, b] = *places;
    ConversationViews conversation{.scene = home.scene, .people = {}, .cameras = {}};
    for (int i = 0; i < views; ++i) {
      const auto spot = draw_camera_place(home, *places, random);
      if (!spot) break;
      const double yaw_rad = std::atan2((a.y + b.y) / 2.0 - spot->y, (a.x + b.x) / 2.0 - spot->x);
      conversation.cameras.push_back(
          {.world_from_camera = {{spot->x, spot->y, kCameraHeight_m},
                                 quaternion_from_euler({.yaw_rad = yaw_rad})},
           .width = width,
           .height = height});
    }
    if (conversation.cameras.size() < static_cast<std::size_t>(views)) continue;
    const double towards_b_rad = std::atan2(b.y - a.y, b.x - a.x);
    const auto add = [&](Gender gender, const Spot& spot, double yaw_rad) {
      const FigureModel& figure =
          figures.draw(gender, draw_posture(random), FigureSplit::train, random);
      conversation.people.push_back(
          add_person(figure, spot.x, spot.y, yaw_rad, conversation.scene));
    };
    add(Gender::female, a, towards_b_rad + random.uniform(-0.4, 0.4));
    add(Gender::male, b, towards_b_rad + kPi + random.uniform(-0.4, 0.4));
    return conversation;
  }
  throw InputError("conversation", "found no free floor for two people and a camera");
}

}  // namespace earpoint::bench

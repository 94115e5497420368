#include <earpoint/generate/conversation_plan.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kAttempts = 2000;
constexpr int kViewpointDraws = 400;
constexpr int kHiddenDraws = 200;
constexpr int kOtherRoomDraws = 100;
constexpr double kListenerRadius_m = 0.25;
constexpr double kBetweenViewpoints_m = 0.6;
// Nobody faces a wall closer than this.
constexpr double kLeastView_m = 1.0;
constexpr double kPersonMargin_m = 0.05;
constexpr double kLongestWalk = 1.8;
// Most people look at the person they talk to, a few past them.
constexpr double kGaze_rad = radians_from_degrees(20.0);

double radius_of(const FigureModel& figure) {
  double radius_m = 0.0;
  for (const auto& p : figure.scene.mesh.positions) {
    radius_m = std::max(radius_m, std::hypot(static_cast<double>(p[0]), p[1]));
  }
  return radius_m;
}

/// Makes attempts until one succeeds. Each draws everything again, so that no place is favoured.
class Planner {
 public:
  Planner(const FloorMap& floor, const RayCaster& caster, const FigureLibrary& figures,
          FigureSplit split, const ConversationOptions& options, RandomStream& random)
      : floor_(floor),
        caster_(caster),
        figures_(figures),
        split_(split),
        options_(options),
        random_(random) {}

  std::optional<ConversationPlan> attempt() {
    ConversationPlan plan;
    const bool woman_first = random_.uniform() < 0.5;
    for (std::size_t i = 0; i < 2; ++i) {
      const Gender gender = (i == 0) == woman_first ? Gender::female : Gender::male;
      const Posture posture =
          random_.uniform() < options_.sitting_share ? Posture::sitting : Posture::standing;
      plan.people[i].figure = &figures_.draw(gender, posture, split_, random_);
      radii_m_[i] = radius_of(*plan.people[i].figure) + kPersonMargin_m;
    }
    if (!place_people(plan) || !place_viewpoints(plan)) return std::nullopt;
    return plan;
  }

 private:
  bool place_people(ConversationPlan& plan) {
    auto& [a, b] = plan.people;
    const auto first = floor_.draw(radii_m_[0], random_);
    if (!first) return false;
    a.at = *first;
    const double least_m = std::max(options_.least_distance_m, radii_m_[0] + radii_m_[1]);
    if (least_m >= options_.most_distance_m) return false;
    const double distance_m = random_.uniform(least_m, options_.most_distance_m);
    const double direction_rad = random_.uniform(-kPi, kPi);
    b.at = {a.at.x + distance_m * std::cos(direction_rad),
            a.at.y + distance_m * std::sin(direction_rad)};
    if (floor_.clearance_m(b.at) < radii_m_[1]) return false;
    a.yaw_rad = wrap_angle(direction_rad + gaze());
    b.yaw_rad = wrap_angle(direction_rad + kPi + gaze());
    return sees(caster_, a.world_from_mouth().position_m, b.world_from_mouth().position_m) &&
           norm(a.world_from_mouth().position_m - b.world_from_mouth().position_m) <=
               options_.most_distance_m;
  }

  double gaze() { return std::clamp(random_.normal(), -3.0, 3.0) * kGaze_rad; }

  bool place_viewpoints(ConversationPlan& plan) {
    const Vector3 mouth_a = plan.people[0].world_from_mouth().position_m;
    const Vector3 mouth_b = plan.people[1].world_from_mouth().position_m;
    const Vector3 middle = (mouth_a + mouth_b) / 2.0;
    const std::vector<FloorPoint> near =
        floor_.within_walk(plan.people[0].at, kLongestWalk * options_.viewpoint_reach_m);
    if (near.empty()) return false;
    // Index of the viewpoint with a speaker out of sight; -1: none.
    std::ptrdiff_t hidden = -1;
    if (random_.uniform() < options_.hidden_share) {
      hidden = static_cast<std::ptrdiff_t>(
          random_.index(static_cast<std::uint64_t>(options_.viewpoints)));
    }
    int draws = 0;
    while (std::ssize(plan.viewpoints) < options_.viewpoints) {
      // Draws nothing if the share is 0, so that plans without other rooms stay the same.
      const bool goes_away = options_.other_room_share > 0.0 && !plan.viewpoints.empty() &&
                             random_.uniform() < options_.other_room_share;
      if (goes_away && place_in_other_room(plan, middle)) continue;
      do {
        if (++draws > kViewpointDraws) return false;
        if (draws > kHiddenDraws) hidden = -1;  // nothing here can hide a speaker
      } while (!place_near(plan, near, middle, std::ssize(plan.viewpoints) == hidden));
    }
    return true;
  }

  bool place_near(ConversationPlan& plan, const std::vector<FloorPoint>& near,
                  const Vector3& middle, bool is_hidden) {
    const FloorPoint at = near[random_.index(near.size())];
    if (!stands_free(plan, at, middle, options_.viewpoint_reach_m)) return false;
    const Vector3 eye = eye_at(at);
    const Pose pose = look_at(eye, {middle.x, middle.y, eye.z});
    if (!has_view(pose)) return false;
    const int seen = mouths_seen(plan, eye);
    if (is_hidden ? seen == 2 : seen == 0) return false;
    plan.viewpoints.push_back(pose);
    return true;
  }

  bool place_in_other_room(ConversationPlan& plan, const Vector3& middle) {
    for (int draw = 0; draw < kOtherRoomDraws; ++draw) {
      const auto at = floor_.draw(kListenerRadius_m, random_);
      if (!at) return false;
      if (!stands_free(plan, *at, middle, options_.other_room_reach_m)) continue;
      const Vector3 eye = eye_at(*at);
      const Pose pose{eye, quaternion_from_euler({.yaw_rad = random_.uniform(-kPi, kPi)})};
      if (mouths_seen(plan, eye) > 0 || !has_view(pose)) continue;
      plan.viewpoints.push_back(pose);
      return true;
    }
    return false;
  }

  Vector3 eye_at(const FloorPoint& at) {
    const double spread_m = options_.height_spread_m;
    return {at.x, at.y,
            options_.height_m + (spread_m > 0.0 ? random_.uniform(-spread_m, spread_m) : 0.0)};
  }

  [[nodiscard]] bool has_view(const Pose& pose) const {
    const auto ahead_m = caster_.distance_m(pose.position_m, rotate(pose.orientation, {1, 0, 0}));
    return !ahead_m || *ahead_m >= kLeastView_m;
  }

  [[nodiscard]] int mouths_seen(const ConversationPlan& plan, const Vector3& eye) const {
    int seen = 0;
    for (const PlannedPerson& person : plan.people) {
      seen += sees(caster_, eye, person.world_from_mouth().position_m) ? 1 : 0;
    }
    return seen;
  }

  [[nodiscard]] bool stands_free(const ConversationPlan& plan, const FloorPoint& at,
                                 const Vector3& middle, double reach_m) const {
    if (floor_.clearance_m(at) < kListenerRadius_m) return false;
    const double distance_m = std::hypot(at.x - middle.x, at.y - middle.y);
    if (distance_m < kBetweenViewpoints_m || distance_m > reach_m) return false;
    for (std::size_t i = 0; i < 2; ++i) {
      const double least_m = radii_m_[i] + kListenerRadius_m;
      if (earpoint::distance_m(at, plan.people[i].at) < least_m) return false;
    }
    return std::none_of(plan.viewpoints.begin(), plan.viewpoints.end(), [&](const Pose& other) {
      return earpoint::distance_m(at, {other.position_m.x, other.position_m.y}) <
             kBetweenViewpoints_m;
    });
  }

  const FloorMap& floor_;
  const RayCaster& caster_;
  const FigureLibrary& figures_;
  FigureSplit split_;
  const ConversationOptions& options_;
  RandomStream& random_;
  std::array<double, 2> radii_m_{};
};

}  // namespace

Pose PlannedPerson::world_from_mouth() const {
  EARPOINT_CHECK(figure != nullptr);
  const Quaternion turn = quaternion_from_euler({.yaw_rad = yaw_rad});
  return {Vector3{at.x, at.y, 0.0} + rotate(turn, figure->mouth_m), turn};
}

ConversationPlan plan_conversation(const FloorMap& floor, const RayCaster& caster,
                                   const FigureLibrary& figures, FigureSplit split,
                                   const ConversationOptions& options, std::string_view scene,
                                   RandomStream& random) {
  EARPOINT_CHECK(options.viewpoints > 1);
  Planner planner(floor, caster, figures, split, options, random);
  for (int i = 0; i < kAttempts; ++i) {
    if (const auto plan = planner.attempt()) return *plan;
  }
  throw InputError(
      scene,
      fmt::format("no space for two people and {} viewpoints on {:.1f} m2 of free floor",
                  options.viewpoints, floor.area_m2()),
      "check its unit and up axis, or give a larger scene");
}

bool sees(const RayCaster& caster, const Vector3& from, const Vector3& to) {
  const Vector3 way = to - from;
  const double length_m = norm(way);
  if (length_m == 0.0) return true;
  const auto distance_m = caster.distance_m(from, way / length_m);
  return !distance_m || *distance_m >= length_m;
}

}  // namespace earpoint

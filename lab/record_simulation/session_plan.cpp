#include <earpoint/record_simulation/session_plan.h>

#include "camera_ring.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kPersonClearance_m = 0.32;
constexpr double kBetweenPeople_m = 0.8;
constexpr double kFromCameras_m = 0.75;
// Share of the distance from the ring's middle to its nearest camera that people use.
constexpr double kStageShare = 0.75;
constexpr double kShortestWalk_m = 0.8;
constexpr double kGaze_rad = radians_from_degrees(20.0);
constexpr double kClapAfterStart_s = 1.0;
constexpr double kTalkAfterClap_s = 1.0;
constexpr double kFirstWalk_s = 6.0;
constexpr int kAttempts = 400;
constexpr int kDraws = 200;

class SessionPlanner {
 public:
  SessionPlanner(const PreparedScene& scene, const FigureLibrary& figures,
                 const SpeechCorpus& corpus, DataSplit split, const SessionOptions& options,
                 RandomStream& random)
      : scene_(scene),
        figures_(figures),
        corpus_(corpus),
        split_(split),
        options_(options),
        random_(random) {}

  SessionPlan plan() {
    const auto ring = place_cameras(scene_, options_.cameras, random_);
    if (!ring) {
      throw InputError(scene_.name,
                       fmt::format("has no space for a ring of {} cameras", options_.cameras),
                       "give a larger scene, another seed or fewer cameras");
    }
    ring_ = *ring;
    plan_.duration_s = options_.duration_s;
    plan_.world_from_camera = ring_.world_from_camera;
    draw_people();
    place_people();
    draw_clap();
    draw_walks();
    std::vector<const SpeechSpeaker*> voices;
    for (const SessionFigure& person : plan_.people) voices.push_back(person.voice);
    plan_.turns =
        draw_turns(voices, plan_.clap_s + kTalkAfterClap_s, options_.duration_s - 0.5, random_);
    draw_clocks();
    return std::move(plan_);
  }

 private:
  void draw_people() {
    const int people = options_.people.value_or(2 + static_cast<int>(random_.index(3)));
    const auto standing = random_.index(static_cast<std::uint64_t>(people));
    const bool woman_first = random_.uniform() < 0.5;
    std::set<std::string> figures;
    std::set<std::string> voices;
    for (int i = 0; i < people; ++i) {
      const Gender gender = (i % 2 == 0) == woman_first ? Gender::female : Gender::male;
      const bool sits =
          static_cast<std::uint64_t>(i) != standing && random_.uniform() < options_.sitting_share;
      SessionFigure person;
      person.name = fmt::format("person-{}", i + 1);
      person.figure = &draw_figure(gender, sits ? Posture::sitting : Posture::standing, figures);
      person.voice = &draw_voice(gender, voices);
      person.microphone_m = draw_microphone();
      plan_.people.push_back(std::move(person));
    }
  }

  // A figure that is not used yet, if there are enough.
  const FigureModel& draw_figure(Gender gender, Posture posture, std::set<std::string>& used) {
    const FigureSplit split = split_ == DataSplit::test ? FigureSplit::test : FigureSplit::train;
    const FigureModel* figure = &figures_.draw(gender, posture, split, random_);
    for (int i = 0; i < kDraws && used.contains(figure->name); ++i) {
      const Posture other = i % 2 == 0 ? posture : Posture::standing;
      figure = &figures_.draw(gender, other, split, random_);
    }
    used.insert(figure->name);
    return *figure;
  }

  const SpeechSpeaker& draw_voice(Gender gender, std::set<std::string>& used) {
    for (int i = 0; i < kDraws; ++i) {
      const SpeechSpeaker* voice = corpus_.draw(gender, split_, random_).speaker;
      if (used.insert(voice->name).second) return *voice;
    }
    throw InputError(
        "the speech",
        fmt::format("has too few {} speakers for the split {}", name_of(gender), name_of(split_)),
        "add speakers, or simulate fewer people");
  }

  // On a collar or a headset: 10 to 20 cm from the mouth, below it and to a side.
  Vector3 draw_microphone() {
    const double distance_m = random_.uniform(0.10, 0.20);
    const double aside_rad = random_.uniform(-0.5, 0.5);
    const double below_rad = random_.uniform(0.5, 1.0);
    return distance_m * Vector3{std::cos(below_rad) * std::cos(aside_rad),
                                std::cos(below_rad) * std::sin(aside_rad), -std::sin(below_rad)};
  }

  [[nodiscard]] bool stands_free(const FloorPoint& at) const {
    if (scene_.floor.clearance_m(at) < kPersonClearance_m) return false;
    return std::none_of(
        plan_.world_from_camera.begin(), plan_.world_from_camera.end(), [&](const Pose& camera) {
          return distance_m(at, {camera.position_m.x, camera.position_m.y}) < kFromCameras_m;
        });
  }

  std::optional<FloorPoint> draw_place() {
    for (int i = 0; i < kDraws; ++i) {
      // Evenly over the disc's area.
      const double radius_m = kStageShare * ring_.least_radius_m * std::sqrt(random_.uniform());
      const double angle_rad = random_.uniform(-kPi, kPi);
      const FloorPoint at{ring_.centre.x + radius_m * std::cos(angle_rad),
                          ring_.centre.y + radius_m * std::sin(angle_rad)};
      if (stands_free(at)) return at;
    }
    return std::nullopt;
  }

  void place_people() {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      std::vector<FloorPoint> places;
      while (places.size() < plan_.people.size()) {
        const auto at = draw_place();
        if (!at) break;
        const bool is_near = std::any_of(places.begin(), places.end(), [&](const FloorPoint& o) {
          return distance_m(*at, o) < kBetweenPeople_m;
        });
        if (is_near) break;
        places.push_back(*at);
      }
      if (places.size() < plan_.people.size()) continue;
      for (std::size_t i = 0; i < places.size(); ++i) {
        std::vector<FloorPoint> others = places;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
        plan_.people[i].path = PersonPath({places[i], yaw_towards(others, places[i])});
      }
      return;
    }
    throw InputError(
        scene_.name,
        fmt::format("has no space for {} people between the cameras", plan_.people.size()),
        "give a larger scene, another seed or fewer people");
  }

  double yaw_towards(const std::vector<FloorPoint>& others, const FloorPoint& at) {
    FloorPoint middle;
    for (const FloorPoint& other : others) {
      middle.x += other.x / static_cast<double>(others.size());
      middle.y += other.y / static_cast<double>(others.size());
    }
    const double gaze_rad = std::clamp(random_.normal(), -3.0, 3.0) * kGaze_rad;
    return wrap_angle(std::atan2(middle.y - at.y, middle.x - at.x) + gaze_rad);
  }

  // In front of the first person, held up so that all cameras see it.
  void draw_clap() {
    plan_.clap_s = options_.most_offset_s + kClapAfterStart_s;
    const Pose mouth = plan_.people[0].world_from_mouth(plan_.clap_s);
    constexpr double kAhead_m = 0.35;
    constexpr double kHeight_m = 1.95;
    plan_.clap_m = mouth.position_m + rotate(mouth.orientation, {kAhead_m, 0.0, 0.0});
    plan_.clap_m.z = kHeight_m;
  }

  // Walks do not overlap in time, so that nobody walks into another.
  void draw_walks() {
    if (options_.walks_per_minute <= 0.0) return;
    const double between_s = 60.0 / options_.walks_per_minute;
    double time_s = std::max(kFirstWalk_s, plan_.clap_s + kTalkAfterClap_s) +
                    between_s * random_.uniform(0.0, 0.5);
    while (time_s < options_.duration_s) {
      double busy_s = 0.0;
      if (const auto walk = draw_walk(time_s)) busy_s = *walk;
      time_s += std::max(busy_s, between_s * random_.uniform(0.5, 1.5));
    }
  }

  /// @return its duration; nothing if no one stands or no way was found
  std::optional<double> draw_walk(double begin_s) {
    std::vector<SessionFigure*> standing;
    for (SessionFigure& person : plan_.people) {
      if (person.figure->posture == Posture::standing) standing.push_back(&person);
    }
    if (standing.empty()) return std::nullopt;
    SessionFigure& person = *standing[random_.index(standing.size())];
    std::vector<FloorPoint> others;
    for (const SessionFigure& other : plan_.people) {
      if (&other != &person) others.push_back(other.path.last().at);
    }
    const Stance from = person.path.last();
    for (int i = 0; i < kDraws; ++i) {
      const auto to = draw_place();
      if (!to || distance_m(from.at, *to) < kShortestWalk_m || !is_way(from.at, *to, others)) {
        continue;
      }
      const Walk walk{.begin_s = begin_s,
                      .from = from.at,
                      .to = *to,
                      .yaw_before_rad = from.yaw_rad,
                      .yaw_after_rad = yaw_towards(others, *to)};
      if (begin_s + walk_duration_s(walk) > options_.duration_s) return std::nullopt;
      person.path.add(walk);
      return walk_duration_s(walk);
    }
    return std::nullopt;
  }

  [[nodiscard]] bool is_way(const FloorPoint& from, const FloorPoint& to,
                            const std::vector<FloorPoint>& others) const {
    constexpr double kStep_m = 0.1;
    const int steps = static_cast<int>(std::ceil(distance_m(from, to) / kStep_m));
    for (int i = 1; i <= steps; ++i) {
      const double share = static_cast<double>(i) / steps;
      const FloorPoint at{from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)};
      if (!stands_free(at)) return false;
      if (std::any_of(others.begin(), others.end(), [&](const FloorPoint& other) {
            return distance_m(at, other) < kBetweenPeople_m;
          })) {
        return false;
      }
    }
    return true;
  }

  void draw_clocks() {
    const auto draw = [&](std::string name, double step_s) {
      double offset_s = random_.uniform(0.0, options_.most_offset_s);
      if (step_s > 0.0) {
        constexpr double kNear_s = 0.01;
        offset_s = step_s * std::floor(offset_s / step_s) + random_.uniform(0.0, kNear_s);
      }
      plan_.clocks.push_back(
          {.name = std::move(name),
           .offset_s = offset_s,
           .drift_ppm = random_.uniform(-options_.most_drift_ppm, options_.most_drift_ppm)});
      plan_.ends_s.push_back(options_.duration_s - random_.uniform(0.0, 0.5));
    };
    for (int i = 0; i < options_.cameras; ++i) {
      draw(std::to_string(i + 1),
           options_.most_offset_s > 0.0 ? 1.0 / options_.frame_rate_hz : 0.0);
    }
    for (const SessionFigure& person : plan_.people) draw(person.name, 0.0);
  }

  const PreparedScene& scene_;
  const FigureLibrary& figures_;
  const SpeechCorpus& corpus_;
  DataSplit split_;
  const SessionOptions& options_;
  RandomStream& random_;
  CameraRing ring_;
  SessionPlan plan_;
};

}  // namespace

Pose SessionFigure::world_from_mouth(double time_s) const {
  const Stance stance = path.at(time_s);
  return PlannedPerson{.figure = figure, .at = stance.at, .yaw_rad = stance.yaw_rad}
      .world_from_mouth();
}

Vector3 SessionFigure::microphone_at(double time_s) const {
  return transform_point(world_from_mouth(time_s), microphone_m);
}

SessionPlan plan_session(const PreparedScene& scene, const FigureLibrary& figures,
                         const SpeechCorpus& corpus, DataSplit split, const SessionOptions& options,
                         RandomStream& random) {
  EARPOINT_CHECK(!options.people || (*options.people >= 2 && *options.people <= 4));
  EARPOINT_CHECK(options.cameras > 0 && options.duration_s >= 10.0 && options.frame_rate_hz > 0.0);
  EARPOINT_CHECK(options.most_drift_ppm >= 0.0 && options.most_offset_s >= 0.0);
  return SessionPlanner(scene, figures, corpus, split, options, random).plan();
}

std::vector<TrackPoint> track_of(const SessionFigure& person, double duration_s) {
  constexpr double kStep_s = 0.1;
  std::vector<double> times_s = {0.0};
  for (const Span& span : person.path.moving()) {
    for (double time_s = span.begin_s; time_s < span.end_s; time_s += kStep_s) {
      times_s.push_back(time_s);
    }
    times_s.push_back(span.end_s);
  }
  times_s.push_back(duration_s);
  std::vector<TrackPoint> track;
  for (const double time_s : times_s) {
    if (!track.empty() && time_s <= track.back().time_s) continue;
    track.push_back({.time_s = time_s,
                     .mouth_m = person.world_from_mouth(time_s).position_m,
                     .yaw_rad = person.path.at(time_s).yaw_rad});
  }
  return track;
}

}  // namespace earpoint

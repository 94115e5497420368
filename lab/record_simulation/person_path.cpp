#include <earpoint/record_simulation/person_path.h>

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kSpeed_m_per_s = 0.8;
constexpr double kTurn_s = 0.6;

/// From 0 to 1 without a jump of speed or acceleration (minimum jerk).
double eased(double fraction) {
  const double u = std::clamp(fraction, 0.0, 1.0);
  return u * u * u * (10.0 - u * (15.0 - 6.0 * u));
}

double turned(double from_rad, double to_rad, double fraction) {
  return wrap_angle(from_rad + eased(fraction) * wrap_angle(to_rad - from_rad));
}

double heading_rad(const Walk& walk) {
  return std::atan2(walk.to.y - walk.from.y, walk.to.x - walk.from.x);
}

double end_s(const Walk& walk) { return walk.begin_s + walk_duration_s(walk); }

Stance on_walk(const Walk& walk, double since_s) {
  const double going_s = walk_duration_s(walk) - 2.0 * kTurn_s;
  const double heading = heading_rad(walk);
  if (since_s < kTurn_s)
    return {walk.from, turned(walk.yaw_before_rad, heading, since_s / kTurn_s)};
  if (since_s > kTurn_s + going_s) {
    return {walk.to, turned(heading, walk.yaw_after_rad, (since_s - kTurn_s - going_s) / kTurn_s)};
  }
  const double share = eased((since_s - kTurn_s) / going_s);
  return {{walk.from.x + share * (walk.to.x - walk.from.x),
           walk.from.y + share * (walk.to.y - walk.from.y)},
          heading};
}

}  // namespace

double walk_duration_s(const Walk& walk) {
  return 2.0 * kTurn_s + distance_m(walk.from, walk.to) / kSpeed_m_per_s;
}

void PersonPath::add(const Walk& walk) {
  EARPOINT_CHECK(walk.from == last().at && !(walk.from == walk.to));
  EARPOINT_CHECK(walk.yaw_before_rad == last().yaw_rad);
  EARPOINT_CHECK(walks_.empty() || walk.begin_s >= end_s(walks_.back()));
  walks_.push_back(walk);
}

Stance PersonPath::at(double time_s) const {
  Stance stance = start_;
  for (const Walk& walk : walks_) {
    if (time_s < walk.begin_s) break;
    if (time_s < end_s(walk)) return on_walk(walk, time_s - walk.begin_s);
    stance = {walk.to, walk.yaw_after_rad};
  }
  return stance;
}

Stance PersonPath::last() const {
  return walks_.empty() ? start_ : Stance{walks_.back().to, walks_.back().yaw_after_rad};
}

std::vector<Span> PersonPath::moving() const {
  std::vector<Span> spans;
  for (const Walk& walk : walks_) spans.push_back({walk.begin_s, end_s(walk)});
  return spans;
}

bool PersonPath::moves_in(const Span& span) const {
  return std::any_of(walks_.begin(), walks_.end(), [&](const Walk& walk) {
    return walk.begin_s < span.end_s && end_s(walk) > span.begin_s;
  });
}

}  // namespace earpoint

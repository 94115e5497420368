#pragma once

#include <vector>

#include <earpoint/generate/floor_map.h>

namespace earpoint {

/// A walk from one place to another: turns on the spot, goes straight, turns on the spot.
struct Walk {
  double begin_s = 0.0;
  FloorPoint from;
  FloorPoint to;
  double yaw_before_rad = 0.0;
  double yaw_after_rad = 0.0;
};

/// Where somebody stands, and which way the face looks.
struct Stance {
  FloorPoint at;
  double yaw_rad = 0.0;

  friend constexpr bool operator==(const Stance&, const Stance&) = default;
};

/// A stretch of time, seconds.
struct Span {
  double begin_s = 0.0;
  double end_s = 0.0;

  friend constexpr bool operator==(const Span&, const Span&) = default;
};

/// How long a walk takes, its turns included: 0.8 m/s on average, in the middle 1.5 m/s.
[[nodiscard]] double walk_duration_s(const Walk& walk);

/// Where somebody is over time: continuous, with continuous speed, and defined for every time.
class PersonPath {
 public:
  PersonPath() = default;
  explicit PersonPath(const Stance& start) : start_(start) {}

  /// @param walk  begins after the last one ended, where that ended
  /// @throws std::logic_error if it does not
  void add(const Walk& walk);

  [[nodiscard]] Stance at(double time_s) const;
  /// After the last walk.
  [[nodiscard]] Stance last() const;
  /// From when to when it moves, ascending.
  [[nodiscard]] std::vector<Span> moving() const;
  [[nodiscard]] bool moves_in(const Span& span) const;

 private:
  Stance start_;
  std::vector<Walk> walks_;
};

}  // namespace earpoint

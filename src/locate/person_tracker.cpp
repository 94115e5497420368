#include <earpoint/locate/person_tracker.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>

#include <earpoint/error.h>
#include <earpoint/locate/assignment.h>
#include <earpoint/locate/box_overlap.h>

namespace earpoint {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
// Least overlap of a detection with the box that is predicted for a person.
constexpr double kLeastOverlap = 0.15;
// Somebody who was hidden may have moved by this share of their height, and look this much larger
// or smaller (as a ratio).
constexpr double kFarthestReturn = 0.75;
constexpr double kLargestGrowth = 1.7;
constexpr double kLongestHidden_s = 1.5;
// Cost of each second without a detection, relative to the overlap.
constexpr double kHiddenCost = 0.3;
// Shares of the box's height: how much a detection jitters, how fast a newly found person may move
// (0.7 m/s at a height of 1.7 m), and how much people change their speed within a second.
constexpr double kDetectionNoise = 0.05;
constexpr double kFirstSpeed = 0.4;
constexpr double kSpeedChange = 0.15;

/// A number and its rate of change from noisy measurements: a Kalman filter of constant velocity.
class MovingNumber {
 public:
  MovingNumber(double value, double noise, double speed)
      : value_(value), variance_(noise * noise), speed_variance_(speed * speed) {}

  void predict(double seconds, double speed_change) {
    value_ += seconds * speed_;
    variance_ += 2.0 * seconds * covariance_ + seconds * seconds * speed_variance_;
    covariance_ += seconds * speed_variance_;
    speed_variance_ += speed_change * speed_change * seconds;
  }

  void measure(double value, double noise) {
    const double total = variance_ + noise * noise;
    const double gain = variance_ / total;
    const double speed_gain = covariance_ / total;
    const double error = value - value_;
    value_ += gain * error;
    speed_ += speed_gain * error;
    speed_variance_ -= speed_gain * covariance_;
    covariance_ *= 1.0 - gain;
    variance_ *= 1.0 - gain;
  }

  [[nodiscard]] double value() const { return value_; }

 private:
  double value_;
  double speed_ = 0.0;
  double variance_;
  double covariance_ = 0.0;
  double speed_variance_;
};

/// Middle and size of a box.
std::array<double, 4> numbers_of(const Box& box) {
  return {0.5 * (box.x_min + box.x_max), 0.5 * (box.y_min + box.y_max), box.x_max - box.x_min,
          box.y_max - box.y_min};
}

double height(const Box& box) { return std::max(box.y_max - box.y_min, 1e-3); }

class Track {
 public:
  Track(const DetectedPerson& person, double time_s, bool is_sure)
      : numbers_(filters_for(person.box)),
        score_(person.score),
        seen_s_(time_s),
        time_s_(time_s),
        is_sure_(is_sure) {}

  void predict(double time_s) {
    const double change = kSpeedChange * height(box());
    for (MovingNumber& moving : numbers_) moving.predict(time_s - time_s_, change);
    time_s_ = time_s;
  }

  void measure(const DetectedPerson& person) {
    const std::array<double, 4> values = numbers_of(person.box);
    const double noise = kDetectionNoise * height(person.box);
    for (std::size_t i = 0; i < 4; ++i) numbers_[i].measure(values[i], noise);
    score_ = person.score;
    seen_s_ = time_s_;
    is_sure_ = true;
  }

  [[nodiscard]] Box box() const {
    const double width = std::max(numbers_[2].value(), 1e-3);
    const double tall = std::max(numbers_[3].value(), 1e-3);
    return {.x_min = std::clamp(numbers_[0].value() - 0.5 * width, 0.0, 1.0),
            .y_min = std::clamp(numbers_[1].value() - 0.5 * tall, 0.0, 1.0),
            .x_max = std::clamp(numbers_[0].value() + 0.5 * width, 0.0, 1.0),
            .y_max = std::clamp(numbers_[1].value() + 0.5 * tall, 0.0, 1.0)};
  }
  [[nodiscard]] double hidden_s() const { return time_s_ - seen_s_; }
  [[nodiscard]] bool is_seen() const { return seen_s_ == time_s_; }
  [[nodiscard]] bool is_sure() const { return is_sure_; }
  [[nodiscard]] bool has_ended() const {
    const Box where = box();
    const bool is_in_picture = where.x_max - where.x_min > 1e-3 && where.y_max - where.y_min > 1e-3;
    return !is_seen() && (!is_sure_ || !is_in_picture || hidden_s() > kLongestHidden_s);
  }

  std::optional<int> number;

  [[nodiscard]] TrackedPerson person() const {
    return {.track = number.value(), .box = box(), .score = score_, .is_seen = is_seen()};
  }

 private:
  static std::array<MovingNumber, 4> filters_for(const Box& box) {
    const std::array<double, 4> values = numbers_of(box);
    const double noise = kDetectionNoise * height(box);
    const double speed = kFirstSpeed * height(box);
    return {MovingNumber(values[0], noise, speed), MovingNumber(values[1], noise, speed),
            MovingNumber(values[2], noise, speed), MovingNumber(values[3], noise, speed)};
  }

  std::array<MovingNumber, 4> numbers_;
  double score_;
  double seen_s_;
  double time_s_;
  bool is_sure_;
};

/// If two people are expected at the same place, the one of the same height who was seen last costs
/// less.
double overlap_cost(const Track& track, const DetectedPerson& person) {
  const double overlap = intersection_over_union(track.box(), person.box);
  if (overlap < kLeastOverlap) return kNever;
  const double growth = std::abs(std::log(height(person.box) / height(track.box())));
  return 1.0 - overlap + growth + kHiddenCost * track.hidden_s();
}

/// For those who do not overlap where they were expected: how far they would have jumped.
double return_cost(const Track& track, const DetectedPerson& person) {
  const std::array<double, 4> expected = numbers_of(track.box());
  const std::array<double, 4> found = numbers_of(person.box);
  const double tall = std::max(height(track.box()), height(person.box));
  const double growth = tall / std::min(height(track.box()), height(person.box));
  const double jump = std::hypot(expected[0] - found[0], expected[1] - found[1]) / tall;
  return jump > kFarthestReturn || growth > kLargestGrowth ? kNever : jump;
}

}  // namespace

struct PersonTracker::State {
  /// Assigns detections to tracks at the least cost and removes both from the given lists.
  template <typename Cost>
  void assign(std::vector<std::size_t>& waiting, std::vector<DetectedPerson>& people, Cost cost) {
    std::vector<std::vector<double>> costs;
    for (const std::size_t track : waiting) {
      costs.emplace_back();
      for (const DetectedPerson& person : people)
        costs.back().push_back(cost(tracks[track], person));
    }
    const auto pairs = cheapest_pairs(costs);
    std::vector<std::size_t> unmatched;
    std::vector<bool> is_taken(people.size(), false);
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      if (pairs[i]) {
        tracks[waiting[i]].measure(people[*pairs[i]]);
        is_taken[*pairs[i]] = true;
      } else {
        unmatched.push_back(waiting[i]);
      }
    }
    waiting = std::move(unmatched);
    std::vector<DetectedPerson> left;
    for (std::size_t i = 0; i < people.size(); ++i) {
      if (!is_taken[i]) left.push_back(people[i]);
    }
    people = std::move(left);
  }

  std::vector<Track> tracks;
  std::optional<double> time_s;
  int next_number = 0;
};

PersonTracker::PersonTracker() : state_(std::make_unique<State>()) {}
PersonTracker::~PersonTracker() = default;
PersonTracker::PersonTracker(PersonTracker&&) noexcept = default;
PersonTracker& PersonTracker::operator=(PersonTracker&&) noexcept = default;

std::vector<TrackedPerson> PersonTracker::update(double time_s,
                                                 std::span<const DetectedPerson> people) {
  State& state = *state_;
  EARPOINT_CHECK(!state.time_s || time_s > *state.time_s);
  const bool is_first = !state.time_s;
  state.time_s = time_s;
  std::vector<DetectedPerson> unassigned(people.begin(), people.end());
  std::vector<std::size_t> waiting;
  for (std::size_t i = 0; i < state.tracks.size(); ++i) {
    state.tracks[i].predict(time_s);
    waiting.push_back(i);
  }
  state.assign(waiting, unassigned, overlap_cost);
  state.assign(waiting, unassigned, return_cost);
  std::erase_if(state.tracks, [](const Track& track) { return track.has_ended(); });
  for (const DetectedPerson& person : unassigned) {
    state.tracks.emplace_back(person, time_s, is_first);
  }
  std::vector<TrackedPerson> tracked;
  for (Track& track : state.tracks) {
    if (!track.is_sure()) continue;
    if (!track.number) track.number = state.next_number++;
    tracked.push_back(track.person());
  }
  std::ranges::sort(tracked, {}, &TrackedPerson::track);
  return tracked;
}

int count_identity_switches(std::span<const std::vector<TrackedPerson>> truth,
                            std::span<const std::vector<TrackedPerson>> tracked) {
  EARPOINT_CHECK(truth.size() == tracked.size());
  constexpr double kFollows = 0.5;
  std::map<int, int> track_of;
  int switches = 0;
  for (std::size_t picture = 0; picture < truth.size(); ++picture) {
    for (const TrackedPerson& person : truth[picture]) {
      const TrackedPerson* best = nullptr;
      for (const TrackedPerson& track : tracked[picture]) {
        const double overlap = intersection_over_union(track.box, person.box);
        if (overlap < kFollows) continue;
        if (best == nullptr || overlap > intersection_over_union(best->box, person.box)) {
          best = &track;
        }
      }
      if (best == nullptr) continue;
      const auto known = track_of.try_emplace(person.track, best->track);
      if (known.first->second != best->track) ++switches;
      known.first->second = best->track;
    }
  }
  return switches;
}

}  // namespace earpoint

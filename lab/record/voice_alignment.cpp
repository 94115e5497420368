#include "voice_alignment.h"

#include "normal_equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <span>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kMargin_m = 0.8;  ///< of the grid around the cameras
constexpr double kStep_m = 0.1;
constexpr double kMostPoints = 6000.0;
constexpr double kInteraural_s = 80e-6;      ///< tolerance of interaural delays
constexpr double kLeastInteraural_s = 1e-3;  ///< more than any head has
constexpr double kTogether_s = 1.5;          ///< a voice hardly moves in this time
constexpr double kPerMillion = 1e-6;

/// Tolerances of a round: of times for places, and of times and drifts for clocks.
struct Round {
  double place_s;
  double clock_s;
  double reach_s;
  double drift_ppm;
};
constexpr Round kFirst{.place_s = 0.0, .clock_s = 6e-3, .reach_s = 80e-3, .drift_ppm = 150.0};
constexpr std::array<Round, 6> kRounds{{{4e-3, 4e-3, 30e-3, 20.0},
                                        {2.5e-3, 3e-3, 20e-3, 16.0},
                                        {1.5e-3, 2e-3, 15e-3, 12.0},
                                        {1e-3, 1.2e-3, 10e-3, 8.0},
                                        {0.6e-3, 0.8e-3, 10e-3, 6.0},
                                        {0.4e-3, 0.6e-3, 10e-3, 6.0}}};

/// 1 at 0, 0 from 1 on, smooth.
double bump(double x) {
  const double rest = std::max(0.0, 1.0 - x * x);
  return rest * rest;
}

/// A score over time: the highest of the bumps that were added around arrivals.
class TimeScore {
 public:
  TimeScore(double first_s, double last_s, double deviation_s)
      : first_s_(first_s),
        reach_s_(2.5 * deviation_s),
        step_s_(deviation_s / 4.0),
        score_(static_cast<std::size_t>((last_s - first_s) / step_s_) + 2) {}

  void add(double time_s, double height) {
    const double at = (time_s - first_s_) / step_s_;
    const double reach = reach_s_ / step_s_;
    const auto begin = std::max(0L, std::lround(std::ceil(at - reach)));
    const auto end = std::min(std::ssize(score_) - 1, std::lround(std::floor(at + reach)));
    for (auto i = begin; i <= end; ++i) {
      const auto value = static_cast<float>(height * bump((static_cast<double>(i) - at) / reach));
      score_[i] = std::max(score_[i], value);
    }
  }

  [[nodiscard]] float at(double time_s) const {
    const auto i = std::lround((time_s - first_s_) / step_s_);
    return i < 0 || i >= std::ssize(score_) ? 0.0F : score_[i];
  }

 private:
  double first_s_;
  double reach_s_;
  double step_s_;
  std::vector<float> score_;
};

/// One time of arrival, compared with a pair of clocks.
struct Arrival {
  double since_s = 0.0;  ///< of session time, from the middle
  double late_s = 0.0;   ///< than both clocks and the place predict
  double height = 0.0;
};

/// Error of one clock of a pair against the other: late = offset + slope since.
struct Line {
  double offset_s = 0.0;
  double slope = 0.0;
  double support = 0.0;
};

/// The line that most arrivals support. In a short session nearly all slopes have the same support:
/// then the one with the least total drift is taken.
/// @param drift  of these clocks against each other so far; the slope is subtracted from it
Line best_line(std::span<const Arrival> arrivals, const Round& round, double drift) {
  constexpr double kUsualDrift = 150e-6;
  constexpr int kSlopes = 38;  // to either side
  constexpr std::ptrdiff_t kHalf = 7;
  const double bin_s = round.clock_s / 6.0;
  const auto bins = static_cast<std::ptrdiff_t>(2.0 * round.reach_s / bin_s);
  std::vector<double> histogram(static_cast<std::size_t>(bins));
  Line best;
  for (int s = -kSlopes; s <= kSlopes; ++s) {
    const double slope = s * round.drift_ppm * kPerMillion / kSlopes;
    std::ranges::fill(histogram, 0.0);
    for (const Arrival& arrival : arrivals) {
      const double left_s = arrival.late_s - slope * arrival.since_s + round.reach_s;
      const auto bin = static_cast<std::ptrdiff_t>(std::floor(left_s / bin_s));
      if (bin >= 0 && bin < bins) histogram[bin] += arrival.height;
    }
    for (std::ptrdiff_t b = kHalf; b + kHalf < bins; ++b) {
      double support = 0.0;
      for (std::ptrdiff_t i = -kHalf; i <= kHalf; ++i) {
        support += histogram[b + i] * bump(static_cast<double>(i) / (kHalf + 1.0));
      }
      const double unusual = (drift - slope) / kUsualDrift;
      support /= 1.0 + unusual * unusual;
      if (support <= best.support) continue;
      best = {(static_cast<double>(b) + 0.5) * bin_s - round.reach_s, slope, support};
    }
  }
  return best;
}

class Alignment {
 public:
  Alignment(const std::vector<FitDevice>& devices, const std::vector<SoundEvent>& events,
            const Vector3& centre_m)
      : devices_(devices), events_(events), places_(events.size()) {
    for (const FitDevice& device : devices) clocks_.push_back(device.clock);
    make_grid(centre_m);
    ways_.resize(devices.size());
    for (std::size_t d = 0; d < devices.size(); ++d) {
      if (!devices[d].world_from_head) continue;
      for (int ear = 0; ear < 2; ++ear) {
        for (const Vector3& point : grid_) {
          ways_[d][ear].push_back(travel_time_s(point, *devices[d].world_from_head, ear));
          longest_s_ = std::max(longest_s_, ways_[d][ear].back());
        }
      }
    }
    double sum_s = 0.0;
    for (const SoundEvent& event : events) sum_s += moment_s(event);
    middle_s_ = sum_s / static_cast<double>(std::max<std::size_t>(events.size(), 1));
  }

  VoiceAlignment run(double error_s) {
    // All places start at the centre, the grid's first point.
    if (error_s > kFirst.clock_s) move_clocks(kFirst);
    for (const Round& round : kRounds) {
      if (round.place_s > error_s) continue;
      find_places(round.place_s);
      move_clocks(round);
    }
    VoiceAlignment result{.clocks = clocks_, .places = {}};
    for (const std::size_t place : places_) result.places.push_back(grid_[place]);
    return result;
  }

 private:
  void make_grid(const Vector3& centre_m) {
    Vector3 least = centre_m;
    Vector3 most = centre_m;
    for (const FitDevice& device : devices_) {
      if (!device.world_from_head) continue;
      const Vector3& at = device.world_from_head->position_m;
      least = {std::min(least.x, at.x), std::min(least.y, at.y), centre_m.z};
      most = {std::max(most.x, at.x), std::max(most.y, at.y), centre_m.z};
    }
    const double length_m = most.x - least.x + 2.0 * kMargin_m;
    const double width_m = most.y - least.y + 2.0 * kMargin_m;
    const double step_m = std::max(kStep_m, std::sqrt(length_m * width_m / kMostPoints));
    grid_.push_back(centre_m);
    for (double x = least.x - kMargin_m; x <= most.x + kMargin_m; x += step_m) {
      for (double y = least.y - kMargin_m; y <= most.y + kMargin_m; y += step_m) {
        grid_.push_back({x, y, centre_m.z});
      }
    }
  }

  [[nodiscard]] double moment_s(const SoundEvent& event) const {
    return session_time_s(clocks_[event.anchor], event.anchor_s);
  }

  /// Travel time from the mouth to the anchor, at which the time of the event is known.
  [[nodiscard]] double anchor_way_s(const SoundEvent& event, std::size_t point) const {
    if (event.anchor_ear) return ways_[event.anchor][*event.anchor_ear][point];
    return devices_[event.anchor].near_distance_m / kSoundMetresPerSecond;
  }

  /// Rate of session time against device time.
  [[nodiscard]] double rate_of(std::size_t device) const {
    return 1.0 / (1.0 + kPerMillion * clocks_[device].drift_ppm);
  }

  /// How much later than the anchor the ear heard the sound, if this time is right.
  [[nodiscard]] double lateness_s(const SoundEvent& event, const HeardEvent& heard,
                                  const HeardTime& time) const {
    return session_time_s(clocks_[heard.device], time.device_s) - moment_s(event);
  }

  /// Agreement of each point of the grid with the arrivals of an event.
  [[nodiscard]] std::vector<float> map_of(const SoundEvent& event, double deviation_s) const {
    std::vector<float> map(grid_.size());
    std::vector<double> anchor_s(grid_.size());
    for (std::size_t g = 0; g < grid_.size(); ++g) anchor_s[g] = anchor_way_s(event, g);
    for (std::size_t first = 0; first < event.heard.size();) {
      const std::size_t camera = event.heard[first].device;
      std::size_t last = first;
      while (last < event.heard.size() && event.heard[last].device == camera) ++last;
      const std::span<const HeardEvent> ears(&event.heard[first], last - first);
      first = last;
      std::vector<float> here(grid_.size());
      for (const HeardEvent& heard : ears) {
        TimeScore score(-longest_s_, 2.0 * longest_s_, deviation_s);
        for (const HeardTime& time : heard.times) {
          score.add(lateness_s(event, heard, time), time.height);
        }
        const std::vector<double>& ways = ways_[camera][heard.ear];
        for (std::size_t g = 0; g < grid_.size(); ++g) here[g] += score.at(ways[g] - anchor_s[g]);
      }
      if (ears.size() == 2) weigh_by_interaural_times(ears, here);
      for (std::size_t g = 0; g < grid_.size(); ++g) map[g] += here[g];
    }
    return map;
  }

  /// Doubles points that agree with the interaural delay of a camera, which does not depend on
  /// clocks.
  void weigh_by_interaural_times(std::span<const HeardEvent> ears, std::vector<float>& map) const {
    TimeScore score(-kLeastInteraural_s, kLeastInteraural_s, kInteraural_s);
    for (const HeardTime& left : ears[0].times) {
      for (const HeardTime& right : ears[1].times) {
        score.add(left.device_s - right.device_s, left.height * right.height);
      }
    }
    const auto& ways = ways_[ears[0].device];
    const auto& left = ways[ears[0].ear];
    const auto& right = ways[ears[1].ear];
    for (std::size_t g = 0; g < map.size(); ++g) map[g] *= 1.0F + score.at(left[g] - right[g]);
  }

  /// Takes for each event the point on which it and neighbouring events of the same voice agree
  /// best.
  void find_places(double deviation_s) {
    std::vector<std::vector<float>> maps;
    maps.reserve(events_.size());
    for (const SoundEvent& event : events_) maps.push_back(map_of(event, deviation_s));
    for (std::size_t e = 0; e < events_.size(); ++e) {
      std::vector<float> sum(grid_.size());
      for (std::size_t other = 0; other < events_.size(); ++other) {
        if (events_[other].anchor != events_[e].anchor ||
            std::abs(events_[other].anchor_s - events_[e].anchor_s) > kTogether_s) {
          continue;
        }
        for (std::size_t g = 0; g < sum.size(); ++g) sum[g] += maps[other][g];
      }
      places_[e] = static_cast<std::size_t>(std::ranges::max_element(sum) - sum.begin());
    }
  }

  /// Moves clocks so that pairs of them agree with the lines that most arrivals support.
  void move_clocks(const Round& round) {
    std::map<std::pair<std::size_t, std::size_t>, std::vector<Arrival>> arrivals;
    for (std::size_t e = 0; e < events_.size(); ++e) {
      const SoundEvent& event = events_[e];
      for (const HeardEvent& heard : event.heard) {
        if (heard.device == event.anchor) continue;
        const double way_s =
            ways_[heard.device][heard.ear][places_[e]] - anchor_way_s(event, places_[e]);
        auto& pair = arrivals[{event.anchor, heard.device}];
        for (const HeardTime& time : heard.times) {
          pair.push_back(
              {moment_s(event) - middle_s_, lateness_s(event, heard, time) - way_s, time.height});
        }
      }
    }
    std::map<std::pair<std::size_t, std::size_t>, Line> lines;
    for (const auto& [pair, list] : arrivals) {
      lines[pair] = best_line(list, round, rate_of(pair.second) - rate_of(pair.first));
    }
    const std::vector<double> offsets_s = agreed(lines, &Line::offset_s, round.clock_s);
    const std::vector<double> slopes = agreed(lines, &Line::slope, kPerMillion * round.drift_ppm);
    for (std::size_t d = 0; d < devices_.size(); ++d) move_clock(d, offsets_s[d], slopes[d]);
  }

  /// A value for each device, 0 for the first, so that differences of pairs match their lines.
  /// Pairs that contradict most others have little weight.
  [[nodiscard]] std::vector<double> agreed(
      const std::map<std::pair<std::size_t, std::size_t>, Line>& lines, double Line::*value,
      double scale) const {
    constexpr int kSteps = 20;
    constexpr double kSmallest = 1e-2;  // of the scale: below it all weights are equal
    std::vector<double> values(devices_.size());
    for (int step = 0; step < kSteps; ++step) {
      NormalEquations equations(devices_.size());
      for (std::size_t d = 0; d < devices_.size(); ++d) {
        equations.add_prior(d, 0.0, d == 0 ? 1e-3 : 1e3);
      }
      for (const auto& [pair, line] : lines) {
        const auto [anchor, camera] = pair;
        const double wanted = line.*value / scale;
        const double off = std::abs(values[camera] - values[anchor] - wanted);
        const double weight = line.support / std::max(step == 0 ? 1.0 : off, kSmallest);
        equations.a(camera, camera) += weight;
        equations.a(anchor, anchor) += weight;
        equations.a(camera, anchor) -= weight;
        equations.a(anchor, camera) -= weight;
        equations.b(camera) += weight * wanted;
        equations.b(anchor) -= weight * wanted;
      }
      values = equations.solve();
    }
    for (double& v : values) v *= scale;
    return values;
  }

  /// Moves a device's times earlier by offset + slope (session time - middle).
  void move_clock(std::size_t device, double offset_s, double slope) {
    DeviceClock& clock = clocks_[device];
    const double rate = (1.0 - slope) * rate_of(device);
    const double begin_s = clock.offset_s - offset_s - slope * (clock.offset_s - middle_s_);
    clock.offset_s = begin_s;
    clock.drift_ppm = (1.0 / rate - 1.0) / kPerMillion;
  }

  const std::vector<FitDevice>& devices_;
  const std::vector<SoundEvent>& events_;
  std::vector<std::size_t> places_;  ///< points of the grid
  std::vector<DeviceClock> clocks_;
  std::vector<Vector3> grid_;                             ///< the centre, then rows
  std::vector<std::array<std::vector<double>, 2>> ways_;  ///< by device, ear, point; of cameras
  double longest_s_ = 0.0;
  double middle_s_ = 0.0;
};

}  // namespace

VoiceAlignment align_voices(const std::vector<FitDevice>& devices,
                            const std::vector<SoundEvent>& events, const Vector3& centre_m,
                            double error_s) {
  EARPOINT_CHECK(!devices.empty());
  return Alignment(devices, events, centre_m).run(error_s);
}

}  // namespace earpoint

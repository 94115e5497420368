#include "clock_fit.h"

#include "normal_equations.h"
#include "offset_support.h"
#include "seats.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/spatial/rigid_sphere.h>

namespace earpoint {
namespace {

constexpr double kTypicalError_s = 0.15e-3;
constexpr double kClapError_s = 0.05e-3;    ///< of one camera
constexpr double kClapWidth_s = 0.2e-3;     ///< smallest width of the Cauchy weights
constexpr double kClapTrust_s = 2e-3;       ///< farther from the others', a clock is wrong
constexpr double kFits_s = 0.6e-3;          ///< larger residuals are of another sound
constexpr double kHeightDeviation_m = 0.3;  ///< of mouths, as people sit or stand
/// Of initial clocks, the reference's too: otherwise errors in its times would move all others.
constexpr double kClockDeviation_s = 0.01;
/// The parameter for drift is the offset after 100 s, so that both are of one size.
constexpr double kDriftTime_s = 100.0;
constexpr double kDriftDeviation_s = 50e-6 * kDriftTime_s;  ///< from zero, as of usual clocks

/// How tolerant the fit is, from the first round to the last.
struct Round {
  double width_s;            ///< of the Cauchy weights
  double place_deviation_m;  ///< of the prior on places, horizontally
};
constexpr std::array<Round, 8> kRounds{{{2e-3, 3.0},
                                        {1e-3, 4.0},
                                        {0.6e-3, 4.0},
                                        {0.4e-3, 4.0},
                                        {0.3e-3, 4.0},
                                        {0.2e-3, 4.0},
                                        {0.1e-3, 4.0},
                                        {0.06e-3, 4.0}}};
/// Seats are estimated again as clocks improve.
struct SeatRound {
  double reach_m;        ///< a voice within this distance of its last place has not moved
  double widest_s;       ///< of Round: with good clocks, larger widths include reflections
  double support_bin_s;  ///< of OffsetSupport
};
constexpr std::array<SeatRound, 3> kSeatRounds{
    {{0.35, 2e-3, 0.1e-3}, {0.15, 0.1e-3, 0.04e-3}, {0.15, 0.1e-3, 0.04e-3}}};
constexpr int kMostPasses = 3;
constexpr int kStepsPerRound = 4;

/// A clock in the fit: session = offset + (1 + slope / kDriftTime_s) (device - middle).
struct ClockState {
  double offset_s = 0.0;
  double slope_s = 0.0;
};

struct Observation {
  std::size_t device = 0;
  double residual_s = 0.0;
  double weight = 0.0;         ///< 1 / s^2
  double device_factor = 0.0;  ///< of slope_s
  Vector3 gradient;            ///< of the residual by the source's place
};

constexpr double kMostDriftError = 100e-6;
constexpr double kUsualDrift = 150e-6;  ///< smaller drift needs less support
constexpr double kClearly = 1.2;        ///< times the support of another drift

class Fit {
 public:
  Fit(const std::vector<FitDevice>& devices, const std::vector<SoundEvent>& events,
      const std::vector<ClapTime>& claps, const std::vector<Vector3>& places_m,
      const Vector3& centre_m)
      : devices_(devices),
        events_(events),
        claps_(claps),
        centre_m_(centre_m),
        places_(places_m),
        seat_of_(events.size()) {
    part_seats();
    for (const FitDevice& device : devices) {
      const double slope = 1.0 / (1.0 + 1e-6 * device.clock.drift_ppm) - 1.0;
      start_.push_back({session_time_s(device.clock, device.middle_s), slope * kDriftTime_s});
    }
    clocks_ = start_;
  }

  ClockFit run() {
    for (const SeatRound& round : kSeatRounds) {
      find_seats(round.reach_m);
      refine(round.widest_s);
      for (int pass = 0; pass < kMostPasses && recentre(round.support_bin_s); ++pass) {
        refine(round.widest_s);
      }
      // People who keep moving a little are recognised only with good clocks.
      part_seats();
      clocks_held_ = true;
      places_ = gathered_places(events_, places_, centre_m_.z);
      refine(kRounds.front().width_s);
      clocks_held_ = false;
    }
    find_seats(kSeatRounds.back().reach_m);
    refine(kSeatRounds.back().widest_s);
    return result();
  }

 private:
  [[nodiscard]] double session_s(std::size_t device, double device_s) const {
    const ClockState& clock = clocks_[device];
    const double since = device_s - devices_[device].middle_s;
    return clock.offset_s + since + clock.slope_s * since / kDriftTime_s;
  }

  [[nodiscard]] double anchor_travel_s(const SoundEvent& event, const Vector3& place) const {
    const FitDevice& anchor = devices_[event.anchor];
    if (!event.anchor_ear) return anchor.near_distance_m / kSoundMetresPerSecond;
    return travel_time_s(place, *anchor.world_from_head, *event.anchor_ear);
  }

  /// How much later than the anchor the ear should hear a source at that place.
  [[nodiscard]] double lateness_s(const SoundEvent& event, const HeardEvent& heard,
                                  const Vector3& place) const {
    return travel_time_s(place, *devices_[heard.device].world_from_head, heard.ear) -
           anchor_travel_s(event, place);
  }

  /// The arrival that fits best by height and residual, with its residual and weight.
  [[nodiscard]] std::optional<Observation> choose(std::size_t e, const HeardEvent& heard,
                                                  double width_s) const {
    const SoundEvent& event = events_[e];
    const double expected =
        session_s(event.anchor, event.anchor_s) + lateness_s(event, heard, places_[e]);
    std::optional<Observation> best;
    double best_score = 0.0;
    for (const HeardTime& time : heard.times) {
      const double residual = session_s(heard.device, time.device_s) - expected;
      const double trust = 1.0 / (1.0 + residual * residual / (width_s * width_s));
      if (time.height * trust <= best_score) continue;
      best_score = time.height * trust;
      best = Observation{
          .device = heard.device,
          .residual_s = residual,
          .weight = best_score / (kTypicalError_s * kTypicalError_s),
          .device_factor = (time.device_s - devices_[heard.device].middle_s) / kDriftTime_s,
          .gradient = {}};
    }
    return best;
  }

  [[nodiscard]] Vector3 gradient(std::size_t e, const HeardEvent& heard) const {
    constexpr double kStep_m = 1e-3;
    const auto along = [&](const Vector3& step) {
      return -(lateness_s(events_[e], heard, places_[e] + step) -
               lateness_s(events_[e], heard, places_[e] - step)) /
             (2.0 * kStep_m);
    };
    return {along({kStep_m, 0, 0}), along({0, kStep_m, 0}), along({0, 0, kStep_m})};
  }

  void improve(const Round& round) {
    const std::size_t size = 2 * devices_.size();
    NormalEquations reduced(size);
    add_clock_priors(reduced);
    add_claps(std::max(round.width_s, kClapWidth_s), reduced);
    std::vector<PlaceEquations> seats(seats_, PlaceEquations(size));
    for (std::size_t e = 0; e < events_.size(); ++e) {
      add_event(e, round, seats[seat_of_[e]]);
    }
    for (const PlaceEquations& seat : seats) seat.eliminate_from(reduced);
    const std::vector<double> step = clocks_held_ ? std::vector<double>(size) : reduced.solve();
    for (std::size_t d = 0; d < devices_.size(); ++d) {
      clocks_[d].offset_s += step[2 * d];
      clocks_[d].slope_s += step[2 * d + 1];
    }
    std::vector<Vector3> moves;
    for (const PlaceEquations& seat : seats) {
      moves.push_back(seat.place_step(step));
      constexpr double kLongest_m = 1.0;
      if (norm(moves.back()) > kLongest_m) {
        moves.back() = moves.back() * (kLongest_m / norm(moves.back()));
      }
    }
    for (std::size_t e = 0; e < events_.size(); ++e) {
      places_[e] = places_[e] + moves[seat_of_[e]];
    }
    normal_ = std::move(reduced);
  }

  void refine(double widest_s) {
    for (const Round& round : kRounds) {
      if (round.width_s > widest_s) continue;
      for (int step = 0; step < kStepsPerRound; ++step) improve(round);
      if (!clocks_held_) hold_to_claps();
    }
  }

  /// Gives every event a place of its own.
  void part_seats() {
    std::iota(seat_of_.begin(), seat_of_.end(), std::size_t{0});
    seats_ = events_.size();
  }

  void find_seats(double reach_m) {
    SharedPlaces found = share_places(events_, std::move(places_), reach_m);
    places_ = std::move(found.places_m);
    seat_of_ = std::move(found.seat_of);
    seats_ = found.seats;
  }

  /// Errors of all arrival times of a device, chosen or not.
  [[nodiscard]] std::vector<ArrivalError> arrival_errors(std::size_t device) const {
    std::vector<ArrivalError> errors;
    for (std::size_t e = 0; e < events_.size(); ++e) {
      const SoundEvent& event = events_[e];
      const double anchor_s = session_s(event.anchor, event.anchor_s);
      for (const HeardEvent& heard : event.heard) {
        if (heard.device != device) continue;
        const double expected = anchor_s + lateness_s(event, heard, places_[e]);
        for (const HeardTime& time : heard.times) {
          errors.push_back({time.device_s - devices_[device].middle_s,
                            session_s(device, time.device_s) - expected, time.height});
        }
      }
    }
    return errors;
  }

  /// Moves each camera to the offset and drift that most of its times support. The fit alone cannot
  /// leave a local optimum at which reflections agree.
  /// @return whether any was moved
  bool recentre(double bin_s) {
    bool moved = false;
    for (std::size_t d = 0; d < devices_.size(); ++d) {
      const std::vector<ArrivalError> errors = arrival_errors(d);
      if (errors.empty()) continue;  // a near microphone
      double longest_s = 1.0;
      for (const ArrivalError& error : errors) {
        longest_s = std::max(longest_s, std::abs(error.since_s));
      }
      const double step = bin_s / longest_s;
      const auto steps = static_cast<int>(kMostDriftError / step);
      const auto support_of = [&](double change) {
        const double unusual = (rate_of(d) - 1.0 - change) / kUsualDrift;
        return OffsetSupport(errors, change, bin_s).most() / (1.0 + unusual * unusual);
      };
      const double now = support_of(0.0);
      double slope = 0.0;
      double most = kClearly * now;
      for (int s = -steps; s <= steps; ++s) {
        const double support = support_of(s * step);
        if (support <= most) continue;
        most = support;
        slope = s * step;
      }
      const double offset_s = OffsetSupport(errors, slope, bin_s).first_s();
      if (slope == 0.0 && std::abs(offset_s) <= OffsetSupport::kSpread * bin_s) continue;
      clocks_[d].offset_s -= offset_s;
      clocks_[d].slope_s -= slope * kDriftTime_s;
      moved = true;
    }
    return moved;
  }

  /// Moves cameras back whose clap is far from the others'. Voices can agree, by their reflections,
  /// with a clock that is ten milliseconds off, and no step of the fit leaves such an optimum.
  void hold_to_claps() {
    constexpr std::size_t kLeastClaps = 3;
    if (claps_.size() < kLeastClaps) return;
    std::vector<double> times_s;
    for (const ClapTime& clap : claps_) times_s.push_back(session_s(clap.device, clap.device_s));
    std::vector<double> sorted = times_s;
    const auto middle = sorted.begin() + std::ssize(sorted) / 2;
    std::ranges::nth_element(sorted, middle);
    for (std::size_t i = 0; i < claps_.size(); ++i) {
      const double late_s = times_s[i] - *middle;
      if (std::abs(late_s) > kClapTrust_s) clocks_[claps_[i].device].offset_s -= late_s;
    }
  }

  /// Rate of session time against device time.
  [[nodiscard]] double rate_of(std::size_t device) const {
    return 1.0 + clocks_[device].slope_s / kDriftTime_s;
  }

  void add_clock_priors(NormalEquations& equations) const {
    for (std::size_t d = 0; d < devices_.size(); ++d) {
      equations.add_prior(2 * d, start_[d].offset_s - clocks_[d].offset_s, kClockDeviation_s);
      equations.add_prior(2 * d + 1, -clocks_[d].slope_s, kDriftDeviation_s);
    }
  }

  /// All cameras have the clap at one unknown time, so that every pair of them must agree.
  void add_claps(double width_s, NormalEquations& equations) const {
    const auto count = static_cast<double>(claps_.size());
    for (std::size_t i = 0; i < claps_.size(); ++i) {
      for (std::size_t j = i + 1; j < claps_.size(); ++j) {
        const ClapTime& a = claps_[i];
        const ClapTime& b = claps_[j];
        const double residual = session_s(a.device, a.device_s) - session_s(b.device, b.device_s);
        const double off = residual / width_s;
        const double weight = 1.0 / (kClapError_s * kClapError_s * (1.0 + off * off) * count);
        const std::array<ClockTerm, 4> terms{
            {{2 * a.device, 1.0},
             {2 * a.device + 1, (a.device_s - devices_[a.device].middle_s) / kDriftTime_s},
             {2 * b.device, -1.0},
             {2 * b.device + 1, -(b.device_s - devices_[b.device].middle_s) / kDriftTime_s}}};
        for (const ClockTerm& p : terms) {
          equations.b(p.unknown) -= weight * p.factor * residual;
          for (const ClockTerm& q : terms) {
            equations.a(p.unknown, q.unknown) += weight * p.factor * q.factor;
          }
        }
      }
    }
  }

  void add_event(std::size_t e, const Round& round, PlaceEquations& equations) const {
    const SoundEvent& event = events_[e];
    const double anchor_factor = (event.anchor_s - devices_[event.anchor].middle_s) / kDriftTime_s;
    equations.add_place_prior(
        centre_m_ - places_[e],
        {round.place_deviation_m, round.place_deviation_m, kHeightDeviation_m});
    for (const HeardEvent& heard : event.heard) {
      const std::optional<Observation> observation = choose(e, heard, round.width_s);
      if (!observation) continue;
      const std::array<ClockTerm, 4> terms{{{2 * heard.device, 1.0},
                                            {2 * heard.device + 1, observation->device_factor},
                                            {2 * event.anchor, -1.0},
                                            {2 * event.anchor + 1, -anchor_factor}}};
      equations.add(terms, gradient(e, heard), observation->residual_s, observation->weight);
    }
  }

  [[nodiscard]] ClockFit result() const {
    ClockFit fit;
    fit.positions = places_;
    // Session time is that of the reference, whose own deviation is zero.
    NormalEquations against_reference = normal_;
    against_reference.fix(0);
    against_reference.fix(1);
    const std::vector<double> variances = against_reference.variances();
    const double reference_rate = rate_of(0);
    const double reference_s = clocks_[0].offset_s - reference_rate * devices_[0].middle_s;
    for (std::size_t d = 0; d < devices_.size(); ++d) {
      DeviceClock clock = devices_[d].clock;
      const double rate = rate_of(d) / reference_rate;
      clock.drift_ppm = d == 0 ? 0.0 : (1.0 / rate - 1.0) * 1e6;
      const double begin_s = clocks_[d].offset_s - rate_of(d) * devices_[d].middle_s;
      clock.offset_s = (begin_s - reference_s) / reference_rate;
      fit.clocks.push_back(clock);
      fit.deviations_s.push_back(d == 0 ? 0.0 : std::sqrt(variances[2 * d]));
    }
    for (std::size_t e = 0; e < events_.size(); ++e) {
      auto& residuals = fit.residuals_s.emplace_back();
      for (const HeardEvent& heard : events_[e].heard) {
        const auto chosen = choose(e, heard, kRounds.back().width_s);
        const bool fits = chosen && std::abs(chosen->residual_s) < kFits_s;
        residuals.push_back(fits ? std::optional(chosen->residual_s) : std::nullopt);
      }
    }
    return fit;
  }

  const std::vector<FitDevice>& devices_;
  const std::vector<SoundEvent>& events_;
  const std::vector<ClapTime>& claps_;
  Vector3 centre_m_;
  std::vector<ClockState> start_;
  std::vector<ClockState> clocks_;
  std::vector<Vector3> places_;       ///< by event
  std::vector<std::size_t> seat_of_;  ///< by event; events of a seat have one place
  std::size_t seats_ = 0;
  bool clocks_held_ = false;
  NormalEquations normal_{0};
};

}  // namespace

double travel_time_s(const Vector3& source_m, const Pose& world_from_head, int ear) {
  const Vector3 to_source = source_m - world_from_head.position_m;
  const double distance_m = std::max(norm(to_source), 1e-3);
  const Vector3 left = rotate(world_from_head.orientation, {0, 1, 0});
  const double towards_left = std::clamp(dot(to_source, left) / distance_m, -1.0, 1.0);
  return distance_m / kSoundMetresPerSecond +
         rigid_sphere_delays_s(distance_m, towards_left)[static_cast<std::size_t>(ear)];
}

ClockFit fit_clocks(const std::vector<FitDevice>& devices, const std::vector<SoundEvent>& events,
                    const std::vector<ClapTime>& claps, const std::vector<Vector3>& places_m,
                    const Vector3& centre_m) {
  EARPOINT_CHECK(places_m.size() == events.size());
  for (const SoundEvent& event : events) {
    EARPOINT_CHECK(event.anchor < devices.size());
    for (const HeardEvent& heard : event.heard) {
      EARPOINT_CHECK(heard.device < devices.size() && devices[heard.device].world_from_head);
    }
  }
  return Fit(devices, events, claps, places_m, centre_m).run();
}

}  // namespace earpoint

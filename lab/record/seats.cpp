#include "seats.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace earpoint {
namespace {

constexpr double kAbsent_s = 60.0;  ///< after a longer silence they may sit elsewhere
constexpr std::size_t kFewestInSeat = 8;

struct Seat {
  std::size_t anchor = 0;
  std::vector<std::size_t> events{};
  Vector3 sum{};
  double last_s = 0.0;

  [[nodiscard]] Vector3 place_m() const { return sum / static_cast<double>(events.size()); }
};

/// The nearest seat of the event's voice within reach of the place; null if there is none.
Seat* nearest_seat(std::vector<Seat>& seats, const SoundEvent& event, const Vector3& place_m,
                   double reach_m) {
  Seat* nearest = nullptr;
  for (Seat& seat : seats) {
    if (seat.anchor != event.anchor || event.anchor_s - seat.last_s > kAbsent_s) continue;
    const Vector3 away = seat.place_m() - place_m;
    const double away_m = std::hypot(away.x, away.y);
    if (away_m > reach_m) continue;
    reach_m = away_m;
    nearest = &seat;
  }
  return nearest;
}

}  // namespace

SharedPlaces share_places(const std::vector<SoundEvent>& events, std::vector<Vector3> places_m,
                          double reach_m) {
  std::vector<Seat> seats;
  for (std::size_t e = 0; e < events.size(); ++e) {
    Seat* seat = nearest_seat(seats, events[e], places_m[e], reach_m);
    if (seat == nullptr) seat = &seats.emplace_back(Seat{.anchor = events[e].anchor});
    seat->events.push_back(e);
    seat->sum = seat->sum + places_m[e];
    seat->last_s = events[e].anchor_s;
  }
  SharedPlaces shared{.places_m = std::move(places_m),
                      .seat_of = std::vector<std::size_t>(events.size())};
  for (const Seat& seat : seats) {
    const bool is_shared = seat.events.size() >= kFewestInSeat;
    for (const std::size_t e : seat.events) {
      if (is_shared) shared.places_m[e] = seat.place_m();
      shared.seat_of[e] = shared.seats;
      if (!is_shared) ++shared.seats;
    }
    if (is_shared) ++shared.seats;
  }
  return shared;
}

std::vector<Vector3> gathered_places(const std::vector<SoundEvent>& events,
                                     const std::vector<Vector3>& places_m, double height_m) {
  constexpr double kAround_s = 2.0;
  constexpr double kFar_m = 0.7;
  constexpr std::size_t kFewest = 4;
  std::vector<Vector3> gathered = places_m;
  for (std::size_t e = 0; e < events.size(); ++e) {
    std::vector<double> x;
    std::vector<double> y;
    for (std::size_t other = 0; other < events.size(); ++other) {
      if (events[other].anchor != events[e].anchor ||
          std::abs(events[other].anchor_s - events[e].anchor_s) > kAround_s) {
        continue;
      }
      x.push_back(places_m[other].x);
      y.push_back(places_m[other].y);
    }
    if (x.size() < kFewest) continue;
    const auto middle = std::ssize(x) / 2;
    std::ranges::nth_element(x, x.begin() + middle);
    std::ranges::nth_element(y, y.begin() + middle);
    if (std::hypot(places_m[e].x - x[middle], places_m[e].y - y[middle]) < kFar_m) continue;
    gathered[e] = {x[middle], y[middle], height_m};
  }
  return gathered;
}

}  // namespace earpoint

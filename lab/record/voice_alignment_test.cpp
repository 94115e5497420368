#include "voice_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>

namespace earpoint {
namespace {

constexpr double kNear_m = 0.15;
constexpr double kWall_m = 2.8;  ///< from the middle to the walls

/// Four cameras around three people with microphones, who sit still and talk in turns. Arrivals are
/// the direct sound, a reflection and false times.
struct Heard {
  std::vector<FitDevice> devices;  ///< initial clocks
  std::vector<DeviceClock> truth;
  std::vector<SoundEvent> events;
  std::vector<Vector3> mouths;  ///< by event
};

struct Options {
  double duration_s = 300.0;
  double drift_ppm = 50.0;
  double start_error_s = 10e-3;
  bool one_hides = false;  ///< the first camera gets only the reflection of the first person
};

constexpr std::size_t kCameras = 4;
constexpr std::array<Vector3, 3> kSeats{{{0.9, 0.2, 1.5}, {-0.6, 0.9, 1.3}, {-0.3, -1.0, 1.6}}};

Heard hear(const Options& options) {
  RandomStream random(7);
  Heard heard;
  for (std::size_t d = 0; d < kCameras + kSeats.size(); ++d) {
    DeviceClock clock{.name = std::to_string(d),
                      .offset_s = random.uniform(-1.0, 1.0),
                      .drift_ppm = random.uniform(-options.drift_ppm, options.drift_ppm)};
    if (d == 0) clock = {.name = "0", .offset_s = 0.0, .drift_ppm = 0.0};
    heard.truth.push_back(clock);
    FitDevice device{.clock = clock,
                     .world_from_head = {},
                     .near_distance_m = kNear_m,
                     .middle_s = 0.5 * options.duration_s};
    device.clock.drift_ppm = 0.0;  // as onsets give it for a short or noisy session
    // The offset at the beginning is known to within an error.
    if (d > 0) device.clock.offset_s += options.start_error_s * random.uniform(-1.0, 1.0);
    if (d < kCameras) {
      const double angle = std::numbers::pi * (0.5 * static_cast<double>(d) + 0.2);
      device.world_from_head = Pose{{2.4 * std::cos(angle), 2.4 * std::sin(angle), 1.5},
                                    quaternion_from_euler({.yaw_rad = angle + std::numbers::pi})};
    }
    heard.devices.push_back(device);
  }
  constexpr double kTurn_s = 4.0;
  for (double time_s = 1.0; time_s < options.duration_s - 1.0; time_s += 0.5) {
    const auto person = static_cast<std::size_t>(time_s / kTurn_s) % kSeats.size();
    const Vector3 mouth = kSeats[person];
    // Each person has the strongest reflection at another wall.
    const std::array<Vector3, kSeats.size()> mirrors{
        {{2.0 * kWall_m - mouth.x, mouth.y, mouth.z},
         {mouth.x, 2.0 * kWall_m - mouth.y, mouth.z},
         {-2.0 * kWall_m - mouth.x, mouth.y, mouth.z}}};
    const Vector3& mirrored = mirrors[person];
    const std::size_t anchor = kCameras + person;
    SoundEvent event{.anchor = anchor, .anchor_ear = {}, .anchor_s = 0.0, .heard = {}};
    event.anchor_s = device_time_s(heard.truth[anchor], time_s + kNear_m / kSoundMetresPerSecond);
    for (std::size_t d = 0; d < kCameras; ++d) {
      for (int ear = 0; ear < 2; ++ear) {
        const Pose& head = *heard.devices[d].world_from_head;
        const auto at = [&](double way_s) {
          return device_time_s(heard.truth[d], time_s + way_s + 20e-6 * random.normal());
        };
        HeardEvent times{.device = d, .ear = ear, .expected_s = at(0.0), .times = {}};
        if (!options.one_hides || d != 0 || person != 0) {
          times.times.push_back({at(travel_time_s(mouth, head, ear)), 1.0});
        }
        times.times.push_back({at(travel_time_s(mirrored, head, ear)), 0.7});
        for (int i = 0; i < 2; ++i) times.times.push_back({at(random.uniform(-0.05, 0.05)), 0.5});
        event.heard.push_back(times);
      }
    }
    heard.events.push_back(event);
    heard.mouths.push_back(mouth);
  }
  return heard;
}

void expect_clocks(const std::vector<DeviceClock>& found, const Heard& heard, double offset_s,
                   double drift_ppm) {
  for (std::size_t d = 0; d < found.size(); ++d) {
    const double middle_s = heard.devices[d].middle_s;
    EXPECT_NEAR(session_time_s(found[d], middle_s), session_time_s(heard.truth[d], middle_s),
                offset_s)
        << d;
    EXPECT_NEAR(found[d].drift_ppm, heard.truth[d].drift_ppm, drift_ppm) << d;
  }
}

TEST(VoiceAlignment, FindsClocksWhoseDriftOutrunsTheBeginning) {
  // 50 ppm are 15 ms after 5 minutes: more than the travel times of voices differ.
  const Heard heard = hear({});
  const VoiceAlignment found = align_voices(heard.devices, heard.events, {0, 0, 1.5}, 0.06);
  // Places are on a grid of 0.1 m, or 0.3 ms; the last round has a width of 0.6 ms.
  expect_clocks(found.clocks, heard, 0.6e-3, 4.0);
  for (std::size_t e = 0; e < heard.events.size(); ++e) {
    const Vector3 off = found.places[e] - heard.mouths[e];
    EXPECT_LE(std::hypot(off.x, off.y), 0.3) << e;
  }
}

TEST(ClockFit, GivesAClapOneTimeAtAllCameras) {
  const Heard heard = hear({.duration_s = 10.0, .drift_ppm = 0.0});
  std::vector<ClapTime> claps;
  for (std::size_t d = 0; d < kCameras; ++d) {
    claps.push_back({d, device_time_s(heard.truth[d], 3.0)});
  }
  const auto spread_s = [&](const auto& clock_of) {
    double least = 1e9;
    double most = -1e9;
    for (const ClapTime& clap : claps) {
      const double time_s = session_time_s(clock_of(clap.device), clap.device_s);
      least = std::min(least, time_s);
      most = std::max(most, time_s);
    }
    return most - least;
  };
  EXPECT_GT(spread_s([&](std::size_t d) { return heard.devices[d].clock; }), 1e-3);
  const ClockFit found = fit_clocks(heard.devices, {}, claps, {}, {0, 0, 1.5});
  // The prior of 10 ms against 0.05 ms of a clap leaves a ten-thousandth of errors of 10 ms. A clap
  // that is off by more than the Cauchy width has a hundredth of the weight.
  EXPECT_LT(spread_s([&](std::size_t d) { return found.clocks[d]; }), 100e-6);
}

TEST(ClockFit, HoldsACameraToItsClapWhereVoicesAgreeWithAWrongClock) {
  constexpr std::size_t kCamera = 1;
  constexpr double kLate_s = 10e-3;
  Heard heard = hear({.duration_s = 60.0, .drift_ppm = 0.0, .start_error_s = 0.0});
  // It hears everybody's voice weakly, and 10 ms later strongly; its clock starts where the late
  // sound fits.
  for (SoundEvent& event : heard.events) {
    for (HeardEvent& ear : event.heard) {
      if (ear.device != kCamera) continue;
      const HeardTime direct = ear.times.front();
      ear.times = {{direct.device_s, 0.4}, {direct.device_s + kLate_s, 1.0}};
    }
  }
  heard.devices[kCamera].clock.offset_s -= kLate_s;
  std::vector<ClapTime> claps;
  for (std::size_t d = 0; d < kCameras; ++d)
    claps.push_back({d, device_time_s(heard.truth[d], 3.0)});
  const auto error_s = [&](const std::vector<ClapTime>& known) {
    const ClockFit found =
        fit_clocks(heard.devices, heard.events, known, heard.mouths, {0, 0, 1.5});
    return std::abs(session_time_s(found.clocks[kCamera], 30.0) -
                    session_time_s(heard.truth[kCamera], 30.0));
  };
  EXPECT_GT(error_s({}), 0.5 * kLate_s);
  // As far as the fit comes with good arrivals: 20 us each.
  EXPECT_LT(error_s(claps), 0.1e-3);
}

TEST(ClockFit, FindsDriftToAFractionOfAPartInAMillion) {
  const Heard heard = hear({});
  const VoiceAlignment about = align_voices(heard.devices, heard.events, {0, 0, 1.5}, 0.06);
  std::vector<FitDevice> devices = heard.devices;
  for (std::size_t d = 0; d < devices.size(); ++d) devices[d].clock = about.clocks[d];
  const ClockFit found = fit_clocks(devices, heard.events, {}, about.places, {0, 0, 1.5});
  // Some hundred times with 20 us of noise each fix a line to 0.02 ms and 0.02 ppm. The unknown
  // heights of mouths shift it by centimetres of distance.
  expect_clocks(found.clocks, heard, 0.15e-3, 0.2);
}

TEST(ClockFit, IsNotMisledByACameraThatHearsSomeoneByAReflection) {
  const Heard heard = hear({.duration_s = 60.0, .one_hides = true});
  const VoiceAlignment about = align_voices(heard.devices, heard.events, {0, 0, 1.5}, 0.06);
  std::vector<FitDevice> devices = heard.devices;
  for (std::size_t d = 0; d < devices.size(); ++d) devices[d].clock = about.clocks[d];
  const ClockFit found = fit_clocks(devices, heard.events, {}, about.places, {0, 0, 1.5});
  // The reflection is 8 ms late: a line through it would be off by some 80 ppm.
  expect_clocks(found.clocks, heard, 0.3e-3, 10.0);
}

}  // namespace
}  // namespace earpoint

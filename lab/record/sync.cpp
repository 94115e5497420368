#include <earpoint/record/sync.h>

#include "clap_times.h"
#include "clock_fit.h"
#include "coarse_alignment.h"
#include "voice_alignment.h"
#include "voice_events.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kClapSearch_s = 60.0;  ///< a clapper is used at the beginning
constexpr double kClapAround_s = 0.06;
constexpr double kClapRise_db = 15.0;
constexpr int kLeastCameras = 3;  ///< needed to locate a place
constexpr int kLeastEars = 4;     ///< needed of an event, so that its place constrains the clocks

/// Clocks are wrong by less than `search_s`, and after the fit by about `error_s`. Unknown drift
/// adds up, so that long sessions begin with their first minutes.
struct Pass {
  double search_s;
  double error_s;
  std::size_t events;
  double longer_than_s;  ///< for such sessions alone
  double until_s;        ///< of session time
};
constexpr double kFirstMinutes_s = 300.0;
constexpr double kManyMinutes_s = 1200.0;
constexpr double kEver_s = 1e9;
constexpr std::array<Pass, 5> kPasses{{{0.06, 0.06, 300, 0.0, kFirstMinutes_s},
                                       {0.03, 4e-3, 300, kFirstMinutes_s, kManyMinutes_s},
                                       {0.03, 4e-3, 300, kManyMinutes_s, kEver_s},
                                       {0.016, 1.5e-3, 600, 0.0, kEver_s},
                                       {0.016, 0.5e-3, 600, 0.0, kEver_s}}};

/// The point nearest to the lines of sight of all cameras.
Vector3 centre_of_attention(const std::vector<DeviceSound>& devices) {
  Vector3 middle{};
  int cameras = 0;
  for (const DeviceSound& device : devices) {
    if (!device.world_from_head) continue;
    middle = middle + device.world_from_head->position_m;
    ++cameras;
  }
  middle = middle / std::max(cameras, 1);
  // Repeated steps to the mean of the nearest points on all lines of sight converge to it.
  Vector3 centre = middle;
  constexpr int kSteps = 50;
  for (int step = 0; step < kSteps; ++step) {
    Vector3 sum{};
    for (const DeviceSound& device : devices) {
      if (!device.world_from_head) continue;
      const Vector3 front = rotate(device.world_from_head->orientation, {1, 0, 0});
      const Vector3 from = device.world_from_head->position_m;
      sum = sum + from + front * std::max(0.5, dot(centre - from, front));
    }
    centre = sum / std::max(cameras, 1);
  }
  centre.z = middle.z;
  return centre;
}

class Synchronizer {
 public:
  Synchronizer(const DeviceSounds& sounds, const SyncOptions& options, ProgressSink& progress)
      : sounds_(sounds), options_(options), progress_(progress) {
    result_.notes = sounds.notes;
  }

  SyncResult run() {
    match_onsets();
    match_claps();
    refine();
    for (std::size_t d = 0; d < result_.devices.size(); ++d) {
      const SyncedDevice& device = result_.devices[d];
      if (device.method != SyncMethod::onsets) continue;
      const bool placed = !device.is_camera || matched_[d].world_from_head;
      result_.notes.push_back(
          fmt::format("{} {} is synchronised by onsets alone, to about ten milliseconds: {}",
                      device.is_camera ? "camera" : "near microphone of", device.clock.name,
                      placed ? "too few voices speak alone" : "it is not calibrated"));
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] const DeviceSound& sound(std::size_t device) const { return matched_[device]; }

  void match_onsets() {
    progress_.begin("matching onsets", static_cast<double>(sounds_.devices.size()), "devices");
    const std::vector<float> reference = onset_strength(sounds_.devices.front().sound);
    for (const DeviceSound& device : sounds_.devices) {
      const bool first = matched_.empty();
      CoarseClock coarse;
      if (!first) coarse = coarse_clock(onset_strength(device.sound), reference);
      if (!first && coarse.significance < kLeastSignificance) {
        result_.notes.push_back(
            fmt::format("{} {} is left out: its sound does not match that of camera {}",
                        device.is_camera ? "camera" : "near microphone of", device.name,
                        matched_.front().name));
        progress_.advance(1.0);
        continue;
      }
      coarse.clock.name = device.name;
      matched_.push_back(device);
      result_.devices.push_back({.clock = coarse.clock,
                                 .is_camera = device.is_camera,
                                 .duration_s = device.sound.duration_s(),
                                 .method = first ? SyncMethod::reference : SyncMethod::onsets,
                                 .windows = 0,
                                 .deviation_s = {},
                                 .clap_s = {}});
      progress_.advance(1.0);
    }
    progress_.finish();
    if (matched_.size() < 2) {
      throw InputError("camera " + matched_.front().name,
                       "no other device recorded the same sounds", "check the files");
    }
  }

  /// Finds the clap in the reference, and in the others at the time that their onsets give.
  void match_claps() {
    const double about_s = options_.clap_s.value_or(0.5 * kClapSearch_s);
    const double around_s = options_.clap_s ? 1.0 : 0.5 * kClapSearch_s;
    const auto reference =
        find_clap(sound(0).sound, std::max(0.0, about_s - around_s), about_s + around_s);
    if (!reference || reference->rise_db < kClapRise_db) {
      result_.notes.emplace_back(
          "no clap was found at the beginning: onsets of speech are matched");
      return;
    }
    for (std::size_t d = 0; d < matched_.size(); ++d) {
      SyncedDevice& device = result_.devices[d];
      const double expected_s = device_time_s(device.clock, reference->time_s);
      const auto clap =
          find_clap(sound(d).sound, expected_s - kClapAround_s, expected_s + kClapAround_s);
      if (clap && clap->rise_db > kClapRise_db) device.clap_s = clap->time_s;
    }
    if (options_.clap_m && matched_.front().world_from_head) start_from_clap(*options_.clap_m);
  }

  /// If the clapper's position is known, clocks start from the time of the clap less its travel
  /// time. Near microphones are assumed at the usual distance of people.
  void start_from_clap(const Vector3& clap_m) {
    constexpr double kToMicrophone_m = 1.5;
    if (!result_.devices.front().clap_s) return;
    const auto way_s = [&](const DeviceSound& device) {
      const double metres = device.world_from_head
                                ? norm(device.world_from_head->position_m - clap_m)
                                : kToMicrophone_m;
      return metres / kSoundMetresPerSecond;
    };
    for (std::size_t d = 0; d < matched_.size(); ++d) find_direct_clap(d, clap_m);
    const double emitted_s = *result_.devices.front().clap_s - way_s(matched_.front());
    for (std::size_t d = 1; d < matched_.size(); ++d) {
      SyncedDevice& device = result_.devices[d];
      if (!device.clap_s || (device.is_camera && !matched_[d].world_from_head)) continue;
      by_clap_.insert(device.clock.name);
      device.clock.offset_s +=
          emitted_s + way_s(matched_[d]) - session_time_s(device.clock, *device.clap_s);
    }
  }

  /// Finds when a camera's ears heard the clap, less the travel time, if its position is known.
  void find_direct_clap(std::size_t d, const Vector3& clap_m) {
    SyncedDevice& device = result_.devices[d];
    const DeviceSound& camera = matched_[d];
    if (!device.clap_s || !camera.world_from_head) return;
    const auto emitted_s =
        clap_emitted_s(camera.sound, *device.clap_s, clap_m, *camera.world_from_head);
    if (!emitted_s) return;
    claps_.push_back({d, *emitted_s});
    device.clap_s =
        *emitted_s + norm(camera.world_from_head->position_m - clap_m) / kSoundMetresPerSecond;
  }

  void refine() {
    std::vector<std::size_t> usable;  // devices of the fit, by index in matched_
    for (std::size_t d = 0; d < matched_.size(); ++d) {
      if (!matched_[d].is_camera || matched_[d].world_from_head) usable.push_back(d);
    }
    const auto cameras =
        std::ranges::count_if(usable, [&](std::size_t d) { return matched_[d].is_camera; });
    if (cameras < kLeastCameras) {
      result_.notes.push_back(
          fmt::format("{} cameras are calibrated: at least {} are needed to correct for the travel "
                      "time of sound",
                      cameras, kLeastCameras));
      return;
    }
    fit(usable);
  }

  void fit(const std::vector<std::size_t>& usable) {
    std::vector<DeviceSound> devices;
    std::vector<FitDevice> start;
    for (const std::size_t d : usable) {
      const DeviceSound& device = matched_[d];
      devices.push_back(device);
      start.push_back({.clock = result_.devices[d].clock,
                       .world_from_head = device.world_from_head,
                       .near_distance_m = device.near_distance_m,
                       .middle_s = 0.5 * device.sound.duration_s()});
    }
    const Vector3 centre = centre_of_attention(devices);
    remove_ways_from(centre, start);
    VoiceEvents finder(devices, centre);
    std::vector<ClapTime> claps;
    for (const ClapTime& clap : claps_) {
      const auto at = std::ranges::find(usable, clap.device);
      if (at == usable.end()) continue;
      claps.push_back({static_cast<std::size_t>(at - usable.begin()), clap.device_s});
    }
    std::vector<SoundEvent> events;
    ClockFit found;
    for (const Pass& pass : kPasses) {
      if (devices.front().sound.duration_s() <= pass.longer_than_s) continue;
      events = finder.find(clocks_of(start), pass.search_s, pass.events, pass.until_s, progress_);
      std::erase_if(events,
                    [](const SoundEvent& event) { return std::ssize(event.heard) < kLeastEars; });
      if (events.empty()) return;
      const VoiceAlignment about = align_voices(start, events, centre, pass.error_s);
      for (std::size_t d = 0; d < start.size(); ++d) start[d].clock = about.clocks[d];
      found = fit_clocks(start, events, claps, about.places, centre);
      for (std::size_t d = 0; d < start.size(); ++d) start[d].clock = found.clocks[d];
    }
    store(usable, events, found);
  }

  /// Onsets were matched without travel time; most sound came from around the centre. Clocks from
  /// the clap already have their travel time removed.
  void remove_ways_from(const Vector3& centre_m, std::vector<FitDevice>& devices) const {
    const auto way_s = [&](const FitDevice& device) {
      return device.world_from_head
                 ? norm(device.world_from_head->position_m - centre_m) / kSoundMetresPerSecond
                 : 0.0;
    };
    const double reference_s = way_s(devices.front());
    for (FitDevice& device : devices) {
      if (by_clap_.contains(device.clock.name)) continue;
      device.clock.offset_s += way_s(device) - reference_s;
    }
  }

  static std::vector<DeviceClock> clocks_of(const std::vector<FitDevice>& devices) {
    std::vector<DeviceClock> clocks;
    clocks.reserve(devices.size());
    for (const FitDevice& device : devices) clocks.push_back(device.clock);
    return clocks;
  }

  void store(const std::vector<std::size_t>& usable, const std::vector<SoundEvent>& events,
             const ClockFit& found) {
    constexpr int kLeastWindows = 10;
    std::vector<int> windows(usable.size());
    for (std::size_t e = 0; e < events.size(); ++e) {
      const double time_s = session_time_s(found.clocks[events[e].anchor], events[e].anchor_s);
      int ears = 0;
      for (std::size_t h = 0; h < events[e].heard.size(); ++h) {
        const auto& residual = found.residuals_s[e][h];
        if (!residual) continue;
        ++ears;
        const std::size_t d = events[e].heard[h].device;
        ++windows[d];
        result_.residuals.push_back({usable[d], time_s, *residual});
      }
      if (ears < kLeastEars) continue;
      ++windows[events[e].anchor];
      result_.voices.push_back({time_s, usable[events[e].anchor], found.positions[e], ears});
    }
    for (std::size_t i = 0; i < usable.size(); ++i) {
      SyncedDevice& device = result_.devices[usable[i]];
      device.windows = windows[i];
      if (i == 0 || windows[i] < kLeastWindows) continue;
      device.clock = found.clocks[i];
      device.deviation_s = found.deviations_s[i];
      device.method = SyncMethod::positions;
    }
  }

  const DeviceSounds& sounds_;
  SyncOptions options_;
  ProgressSink& progress_;
  std::vector<DeviceSound> matched_;
  std::vector<ClapTime> claps_;    ///< by index in matched_
  std::set<std::string> by_clap_;  ///< devices whose clocks start from the clap
  SyncResult result_;
};

double percentile95(std::vector<double> values) {
  std::ranges::sort(values);
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(values.size())));
  return values.at(std::max<std::size_t>(rank, 1) - 1);
}

const DeviceClock& truth_of(const SyncedDevice& device, const SessionTruth& truth) {
  const std::vector<DeviceClock>& clocks = device.is_camera ? truth.cameras : truth.microphones;
  const auto found = std::ranges::find(clocks, device.clock.name, &DeviceClock::name);
  if (found == clocks.end()) {
    throw InputError(
        "truth",
        "has no " + std::string(device.is_camera ? "camera " : "microphone ") + device.clock.name);
  }
  return *found;
}

}  // namespace

std::string_view name_of(SyncMethod method) {
  switch (method) {
    case SyncMethod::reference:
      return "reference";
    case SyncMethod::positions:
      return "positions";
    case SyncMethod::onsets:
      return "onsets";
  }
  return "";
}

const SyncedDevice* SyncResult::find(const std::string& name) const {
  for (const SyncedDevice& device : devices) {
    if (device.clock.name == name) return &device;
  }
  return nullptr;
}

SyncResult synchronize(const DeviceSounds& sounds, const SyncOptions& options,
                       ProgressSink& progress) {
  EARPOINT_CHECK(!sounds.devices.empty());
  return Synchronizer(sounds, options, progress).run();
}

SyncErrors compare_clocks(const SyncResult& result, const SessionTruth& truth, double duration_s) {
  SyncErrors errors;
  std::vector<double> offsets_ms;
  const DeviceClock& reference = truth_of(result.devices.front(), truth);
  for (std::size_t d = 1; d < result.devices.size(); ++d) {
    const SyncedDevice& device = result.devices[d];
    const DeviceClock& clock = truth_of(device, truth);
    double largest_ms = 0.0;
    for (double time_s = 0.0; time_s <= duration_s; time_s += 1.0) {
      const double device_s = device_time_s(device.clock, time_s);
      const double true_s = device_time_s(reference, session_time_s(clock, device_s));
      const double error_ms = 1e3 * std::abs(true_s - time_s);
      offsets_ms.push_back(error_ms);
      largest_ms = std::max(largest_ms, error_ms);
    }
    errors.offset_errors_ms.push_back(largest_ms);
    const double true_drift_ppm =
        ((1.0 + 1e-6 * clock.drift_ppm) / (1.0 + 1e-6 * reference.drift_ppm) - 1.0) * 1e6;
    errors.drift_errors_ppm.push_back(std::abs(device.clock.drift_ppm - true_drift_ppm));
  }
  if (offsets_ms.empty()) return errors;
  errors.offset_error_ms_p95 = percentile95(std::move(offsets_ms));
  errors.drift_error_ppm_p95 = percentile95(errors.drift_errors_ppm);
  return errors;
}

}  // namespace earpoint

#pragma once

#include "clock_fit.h"

#include <cstddef>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/record/device_sound.h>

namespace earpoint {

/// Length of the stretches of speech that are found again.
inline constexpr double kEvent_s = 0.5;

/// Finds stretches in which one person speaks alone, by the near microphones, and the times at
/// which every ear may have heard them.
class VoiceEvents {
 public:
  /// @param devices   must outlive this; near microphones, or else the first camera, tell who
  ///                  speaks
  /// @param centre_m  about where people are
  VoiceEvents(const std::vector<DeviceSound>& devices, const Vector3& centre_m);

  /// @param clocks    of the devices, wrong by less than `search_s`
  /// @param most      events, spread over the time
  /// @param until_s   of session time
  [[nodiscard]] std::vector<SoundEvent> find(const std::vector<DeviceClock>& clocks,
                                             double search_s, std::size_t most, double until_s,
                                             ProgressSink& progress) const;

 private:
  struct Moment {
    std::size_t anchor = 0;
    double session_s = 0.0;
  };
  [[nodiscard]] std::vector<Moment> moments(const std::vector<DeviceClock>& clocks,
                                            double until_s) const;

  const std::vector<DeviceSound>& devices_;
  Vector3 centre_m_;
  std::vector<std::vector<float>> levels_db_;  ///< by device, every kLevelHop_s; empty of others
};

}  // namespace earpoint

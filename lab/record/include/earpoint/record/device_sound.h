#pragma once

#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/pose.h>
#include <earpoint/record/session.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Rate at which devices are compared.
inline constexpr int kSyncRateHz = 16000;

/// What one device of a session recorded, on its own clock: sample k at k / kSyncRateHz.
struct DeviceSound {
  std::string name;  ///< of the camera or of the person who wears the microphone
  bool is_camera = false;
  std::optional<Pose> world_from_head;  ///< of calibrated cameras
  double near_distance_m = 0.0;         ///< of near microphones, from the mouth
  Waveform sound;                       ///< 2 ears, or the one channel of a near microphone
};

/// The devices whose sound can be used, cameras first, in the session's order, and one line for
/// each thing that is wrong with the others: a file that is missing, damaged or ends early (what
/// came before is used), a camera with mono sound, a silent device.
struct DeviceSounds {
  std::vector<DeviceSound> devices;
  std::vector<std::string> notes;
};

/// Reads the sounds of all devices. Memory: 64 kB a second and device channel.
/// @throws InputError if fewer than two cameras can be used; it tells why
[[nodiscard]] DeviceSounds read_device_sounds(const Session& session, ProgressSink& progress);

}  // namespace earpoint

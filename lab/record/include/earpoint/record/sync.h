#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/record/device_sound.h>
#include <earpoint/record/session_truth.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// How a clock was found.
enum class SyncMethod {
  reference,  ///< session time is this device's
  positions,  ///< by sounds, the ways that they travel removed
  onsets,  ///< by sounds alone: to about ten milliseconds, as it is not known where the device is
};
[[nodiscard]] std::string_view name_of(SyncMethod method);

struct SyncedDevice {
  DeviceClock clock;  ///< against session time, which is the first camera's clock
  bool is_camera = false;
  double duration_s = 0.0;  ///< of its recording, on its own clock
  SyncMethod method = SyncMethod::onsets;
  int windows = 0;                    ///< stretches of speech that it was found by
  std::optional<double> deviation_s;  ///< one standard deviation of the offset, as the fit has it
  std::optional<double> clap_s;       ///< when the clapper is heard, on its own clock
};

/// Where a voice was in half a second of session time.
struct LocatedVoice {
  double time_s = 0.0;
  std::size_t device = 0;  ///< its near microphone, in SyncResult::devices
  Vector3 mouth_m;
  int ears = 0;  ///< whose times agree with that place
};

/// What is left of a time at which an ear heard a voice, for plots.
struct SyncResidual {
  std::size_t device = 0;
  double time_s = 0.0;
  double residual_s = 0.0;
};

/// Whose voice a near microphone has.
struct MicrophoneWearer {
  std::string microphone;  ///< called like the person whose it is by the session
  std::string person;
  double certainty = 0.0;  ///< 0.5 to 1: that it is that person and no other
};

struct SyncResult {
  std::vector<SyncedDevice> devices;  ///< cameras first, in the session's order
  std::vector<LocatedVoice> voices;   ///< by time
  std::vector<SyncResidual> residuals;
  std::vector<MicrophoneWearer> wearers;  ///< where the session has boxes that tell
  std::vector<std::string> notes;         ///< one line each: what the user should know

  /// @return nullptr if there is no such device, or it could not be matched
  [[nodiscard]] const SyncedDevice* find(const std::string& name) const;
};

struct SyncOptions {
  std::optional<double> clap_s;  ///< as Session has them
  std::optional<Vector3> clap_m;
};

/// Finds every device's offset and drift.
///
/// Onsets of sound, the clapper's among them, are matched over the whole session, which gives
/// clocks to about ten milliseconds. Then voices are found again, half a second at a time, from the
/// near microphone of who speaks alone in every ear of every camera, by GCC-PHAT. How long a voice
/// travels depends on where it is, which is not known: places and clocks are found together, such
/// that all ears agree. A clapper whose place is known counts where both ears of a camera heard it
/// directly. Without near microphones the first camera stands for them.
/// @throws InputError if no device matches the first camera
[[nodiscard]] SyncResult synchronize(const DeviceSounds& sounds, const SyncOptions& options,
                                     ProgressSink& progress);

/// How far clocks are from the truth, relative to the first camera's.
struct SyncErrors {
  double offset_error_ms_p95 = 0.0;  ///< over devices and every second of the session
  double drift_error_ppm_p95 = 0.0;  ///< over devices
  std::vector<double>
      offset_errors_ms;  ///< the largest of each device but the first, by SyncResult::devices
  std::vector<double> drift_errors_ppm;
};

/// @param duration_s  of the session
/// @throws InputError naming a device that the truth does not have
[[nodiscard]] SyncErrors compare_clocks(const SyncResult& result, const SessionTruth& truth,
                                        double duration_s);

}  // namespace earpoint

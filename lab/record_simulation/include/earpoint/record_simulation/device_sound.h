#pragma once

#include <memory>
#include <span>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/record/session_truth.h>
#include <earpoint/record_simulation/session_plan.h>
#include <earpoint/record_simulation/session_speech.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The rate of every device.
inline constexpr int kDeviceRate_hz = 48000;

/// What a device with its own clock records of sound in session time, at the sound's nominal rate:
/// read between the samples by a windowed sinc (to 45 % of the rate within 0.01 dB, errors below
/// -90 dB).
/// @param sound  sample i is at session time i / rate; silent before and behind
/// @param end_s  session time at which the recording ends; it begins at clock.offset_s
Waveform recorded_by(const DeviceClock& clock, const Waveform& sound, double end_s);

/// The mean square of speech at the cameras, both ears and all cameras together, while anybody
/// speaks.
/// @param speech  without the clap
double mean_speech_power(const SessionSound& speech, const SessionPlan& plan);

/// Makes recordings out of what devices hear.
class SessionRecorder {
 public:
  /// @param noise_power  mean square of the ambient noise at every place, before a device's gain
  SessionRecorder(const HrtfSet& ears, double noise_power);
  ~SessionRecorder();

  /// @param heard   speech and clap, at the device's rate, two channels
  /// @param random  of the noise
  /// @return the camera's sound, gain included
  [[nodiscard]] Waveform camera(const Waveform& heard, const DeviceClock& clock, double end_s,
                                RandomStream& random) const;
  /// The same for a near microphone, one channel.
  [[nodiscard]] Waveform microphone(const Waveform& heard, const DeviceClock& clock, double end_s,
                                    RandomStream& random) const;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

}  // namespace earpoint

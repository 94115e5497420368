#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/spatial/arrival.h>
#include <earpoint/trace/moving_sound.h>

namespace earpoint {

/// A stretch of output around one step of a motion: it is faded in from the step before and out to
/// the step behind.
struct MotionWindow {
  double time_s = 0.0;  ///< of the step
  double step_s = 0.0;
  int sample_rate_hz = 0;
  std::ptrdiff_t begin = 0;  ///< samples of the output
  std::ptrdiff_t end = 0;

  /// The steps' weights add up to one.
  [[nodiscard]] float weight(std::ptrdiff_t sample) const;
};

/// Sends a sound along sharp arrivals whose ways change under it: every arrival is filtered as it
/// is at a step (its bands' gains, its head filters) and then read with the delay that its way has
/// at every moment.
class EarlyMotion {
 public:
  EarlyMotion(std::span<const float> sound, const Motion& motion, const Microphone& microphone,
              double speed_m_per_s);

  /// Adds the arrivals of a step.
  /// @param arrivals  directions in the world's frame
  /// @param channels  the output, [channel][sample]
  void add(const MotionWindow& window, std::span<const Arrival> arrivals,
           std::span<std::vector<float>> channels) const;

 private:
  struct Way;      // an arrival as a function of time
  struct Segment;  // the part of the sound that a window needs
  void play(const MotionWindow& window, const Way& way, Segment& segment,
            std::span<std::vector<float>> channels) const;
  void play_ears(const MotionWindow& window, const Way& way, Segment& segment,
                 std::span<std::vector<float>> channels) const;

  std::span<const float> sound_;
  const Motion& motion_;
  const Microphone& microphone_;
  double speed_m_per_s_;
};

}  // namespace earpoint

#include <earpoint/synthesis/input_synthesizer.h>

namespace earpoint {

WindowShape InputSynthesizer::window_shape(int source_rate_hz) const {
  return {.sample_rate_hz = source_rate_hz, .samples = source_rate_hz, .overlap = 0, .context = 0};
}

void InputSynthesizer::observe(const Observation& observation) { sound_ = observation.sound; }

Waveform InputSynthesizer::synthesize(const Pose& /*source_from_target*/) { return sound_; }

}  // namespace earpoint

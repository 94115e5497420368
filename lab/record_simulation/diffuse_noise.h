#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Ambient sound that comes from everywhere alike: noise of equal power per octave from 60 Hz to
/// 12 kHz. Between two ears its coherence and levels are those of the head in a diffuse field: high
/// below 500 Hz, near zero above.
class DiffuseNoise {
 public:
  /// One omnidirectional microphone.
  explicit DiffuseNoise(int sample_rate_hz);
  /// Two ears.
  explicit DiffuseNoise(const HrtfSet& ears);

  /// @return [channels][samples]; the mean square is 1, of two ears together
  [[nodiscard]] Waveform make(std::ptrdiff_t samples, RandomStream& random) const;

 private:
  int sample_rate_hz_;
  // [output][input][taps]: independent white noises become the outputs.
  std::vector<std::vector<std::vector<float>>> filters_;
};

}  // namespace earpoint

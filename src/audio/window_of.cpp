#include <earpoint/audio/window_of.h>

#include <algorithm>

#include <earpoint/error.h>

namespace earpoint {

Waveform window_of(const Waveform& sound, std::ptrdiff_t start, std::ptrdiff_t samples) {
  EARPOINT_CHECK(start >= 0);
  Waveform window(sound.channels(), samples, sound.sample_rate_hz());
  const std::ptrdiff_t first = std::min(start, sound.samples());
  const std::ptrdiff_t count = std::min(sound.samples() - first, samples);
  for (int c = 0; c < sound.channels(); ++c) {
    std::copy_n(sound.channel(c).begin() + first, count, window.channel(c).begin());
  }
  return window;
}

}  // namespace earpoint

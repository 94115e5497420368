#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include <earpoint/record/session_truth.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The sound of a device on session time, from a moment on: offset and drift are taken out by
/// resampling. Silence before the device began and after it ended, or where its file is damaged.
/// Memory: a few seconds.
class AlignedSound {
 public:
  /// @param path      a movie with binaural sound, or the file of a near microphone
  /// @param channels  2, or 1: the first of a near microphone's
  /// @param begin_s   session time of the first sample
  /// @throws InputError as AudioReader
  AlignedSound(const std::filesystem::path& path, int channels, const DeviceClock& clock,
               double begin_s, int sample_rate_hz);
  ~AlignedSound();
  AlignedSound(AlignedSound&&) noexcept;
  AlignedSound& operator=(AlignedSound&&) noexcept;

  /// The next samples: by a sinc of 32 taps under a Hann window, flat to 0.85 of the Nyquist
  /// frequency. @param frames  > 0
  [[nodiscard]] Waveform read(std::ptrdiff_t frames);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint

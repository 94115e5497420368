#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Windows of a sound file, at another rate, one after the other. Memory: the blocks under the
/// window.
class SlidingSound {
 public:
  /// @throws InputError as SoundReader
  SlidingSound(const std::filesystem::path& path, int sample_rate_hz);

  /// @param begin    in samples at the rate asked for; not before that of the last call
  /// @return  zeros behind the file's end
  [[nodiscard]] Waveform window(std::ptrdiff_t begin, std::ptrdiff_t samples);

 private:
  SoundReader reader_;
  StreamResampler resampler_;
  int rate_hz_;
  std::vector<std::vector<float>> held_;  ///< by channel, from sample `first_` on
  std::ptrdiff_t first_ = 0;
  bool ended_ = false;
};

}  // namespace earpoint

#pragma once

#include <span>
#include <vector>

#include <earpoint/audio/stft.h>

namespace earpoint {

/// Squared magnitudes of a short-time Fourier transform, row-major [frames][bins].
struct PowerSpectrogram {
  int frames = 0;
  int bins = 0;
  std::vector<float> values;
};

/// As Stft, but the signal continues as its mirror image on both sides, the end samples not
/// repeated: the padding of torch.stft, and of librosa.stft before its version 0.10.
/// @param signal  shape [samples], samples > fft_size / 2
/// @return        1 + floor(samples / hop) frames
[[nodiscard]] PowerSpectrogram reflected_power(const StftShape& shape,
                                               std::span<const float> signal);

}  // namespace earpoint
